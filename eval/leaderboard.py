"""Merges records into one page of ranked tables: what it shows has been recomputed from the records' tables.

For each suite the official runs come first, one table a level of information. Other runs stand apart, and only those
over the same encounters share a table, since the ranking compares policies encounter by encounter.
"""

from __future__ import annotations

import itertools
import os
import re
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np

from rss_gym import baselines
from rss_gym.eval import ranking
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.reading import Policy, Record, RecordError, load
from rss_gym.eval.records import SCORES, TABLES
from rss_gym.eval.report.tables import FIRST, barred, cell, difference, heading, main_metrics, place_cell, scrolled
from rss_gym.eval.suites import SUITES
from rss_gym.eval.verify import definition, entries_of, metrics_differences, official
from rss_gym.files import new_folder
from rss_gym.pages.page import Section, render, text
from rss_gym.params import Information

PAGE, RECORDS = "index.html", "records"
LEVELS = {
    "oracle": "true states of the others",
    "positions": "range by radio, and positions exchanged once warned",
    "ranges": "range by radio and velocities, no positions",
}
RANKING = (
    "Ranked by mean cost: mean deviation while flown, plus 100 m for an sNMAC and 10,000 m for a collision. Beside it "
    "stands by how much that is more than the first one's on the same encounters; where the 95 % interval of the pairs "
    "holds zero, the two are not told apart. * marks the front: no other policy has both fewer collisions and less "
    "deviation. A policy with a fault (an action that is not finite) is not ranked and shown in red."
)


@dataclass(frozen=True, eq=False)
class BoardRow:
    """One policy of one record, without its table."""

    record: int  # place in the list of records, from 1
    run: tuple[str, str, int, int]  # suite, split, seed, episodes: the encounters
    official: bool
    name: str
    spec: str
    hash: str
    information: str
    metrics: dict[str, Estimate]
    faults: int
    costs: Costs
    min_separation_m: np.ndarray
    shown: tuple[str, ...]  # metrics, that of the ranking first

    @property
    def key(self) -> str:
        """Unique among all rows."""
        return f"{self.name} (record {self.record})"

    @property
    def shipped(self) -> bool:
        """Whether the specification alone says which policy it is."""
        inner = self.spec
        while baselines.is_known(inner) and (base := baselines.parse(inner).base):
            inner = base
        return baselines.is_known(inner)

    def candidate(self) -> ranking.Candidate:
        """What the ranking needs."""
        return ranking.Candidate(self.key, self.faults, self.costs, np.arange(len(self.costs)))


@dataclass(frozen=True)
class Source:
    """A record on the page: where it is copied to, and what the list of records says of it."""

    folder: Path
    copy: str
    files: tuple[str, ...]
    suite: str
    suite_hash: str
    seed: int
    episodes: int
    official: bool
    versions: dict[str, str]


@dataclass(frozen=True)
class Site:
    """What `build` made, and what a reader of the page should know about the merge."""

    page: Path
    notes: tuple[str, ...]


def build(folders: Sequence[str | os.PathLike[str]], out: str | os.PathLike[str]) -> Site:
    """Write the new folder `out` with `index.html` and a copy of each record shown.

    Raises
    ------
    RecordError
        If a folder does not hold an intact record, its metrics are not those of its tables, its suite is not defined
        today as it was, or two records contradict each other.
    ParamsError
        If `out` exists or cannot be written.
    """
    sources: list[Source] = []
    rows: list[BoardRow] = []
    for number, folder in enumerate(folders, 1):
        record = load(folder)
        _check(record)
        sources.append(_source(record, number))
        rows += [_row(record, policy, number) for policy in record.policies]
    for suite in {source.suite for source in sources}:
        hashes = {source.suite_hash: source.folder for source in sources if source.suite == suite}
        if len(hashes) > 1:
            (one, first), (other, second), *_ = hashes.items()
            raise RecordError(
                f"{second}: suite_hash of {suite!r} is {other[:12]}..., but {one[:12]}... in {first}: scores of two "
                "definitions are not comparable; make a page of each"
            )
    kept, notes = merge(rows, sources)
    with new_folder(out) as site:
        for number in sorted({row.record for row in kept}):
            source = sources[number - 1]
            for file in source.files:
                target = site / source.copy / file
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source.folder / file, target)
        (site / PAGE).write_text(markup(kept, sources, notes), encoding="utf-8")
    return Site(Path(out) / PAGE, tuple(notes))


def _check(record: Record) -> None:
    """Refuse claims that can be found wrong without a flight, and a part of a run."""
    if record.first_episode:
        raise RecordError(
            f"{record.folder}: first_episode = {record.first_episode} must be 0: a part of a run has no place on a "
            "leaderboard; merge its parts"
        )
    suite = definition(record)
    if (suite.hash, suite.split) != (record.suite_hash, record.split):
        raise RecordError(
            f"{record.folder}: suite_hash of {record.suite!r} is {record.suite_hash[:12]}..., but today's definition "
            f"with the record's parameters has {suite.hash[:12]}...; use the version of rss-gym that wrote the record"
        )
    if record.official != official(record):
        raise RecordError(
            f"{record.folder}: official = {record.official} must be {official(record)} for seed {record.seed} and "
            f"{record.episodes} encounters of {record.suite!r} with these parameters"
        )
    _, _, claims = entries_of(record, suite)
    differences = claims + metrics_differences(record, suite)
    if differences:
        raise RecordError(f"{record.folder}: {differences[0]}; `rss-gym verify` lists all differences")


def _source(record: Record, number: int) -> Source:
    name = re.sub("[^A-Za-z0-9._-]+", "-", record.folder.resolve().name)[:80]
    return Source(
        folder=record.folder,
        copy=f"{RECORDS}/{number}-{name}",
        files=(SCORES, *(policy.file for policy in record.policies)),
        suite=record.suite,
        suite_hash=record.suite_hash,
        seed=record.seed,
        episodes=record.episodes,
        official=record.official,
        versions=record.versions,
    )


def _row(record: Record, policy: Policy, number: int) -> BoardRow:
    return BoardRow(
        record=number,
        run=(record.suite, record.split, record.seed, record.episodes),
        official=record.official,
        name=policy.name,
        spec=policy.spec,
        hash=policy.hash,
        information=policy.information,
        metrics=policy.metrics,
        faults=int(np.count_nonzero(policy.table["fault"])),
        costs=Costs.of(policy.table, Prices.of(record.params)),
        min_separation_m=policy.table["min_separation_m"].copy(),
        shown=main_metrics(record.params),
    )


def merge(rows: Iterable[BoardRow], sources: Sequence[Source]) -> tuple[list[BoardRow], list[str]]:
    """Each policy once a suite, from its official or else longest run; and what was left out or looks odd.

    Two rows are one policy if their hashes agree and, on common encounters, their flights do. A hash covers the
    specification, not the code behind `module:attribute`: such policies may differ, those of the package may not.

    Raises
    ------
    RecordError
        If two records have other flights of a policy of the package on the same encounters.
    """
    kept: list[BoardRow] = []
    notes: list[str] = []
    for row in sorted(rows, key=lambda row: (not row.official, -row.run[-1], row.record)):
        same = [one for one in kept if (one.run[0], one.hash) == (row.run[0], row.hash)]
        twin = None
        for one in same:
            overlap = _differing(one, row)
            if overlap is not None and overlap >= 0 and row.shipped:
                folders = f"{sources[row.record - 1].folder} and {sources[one.record - 1].folder}"
                raise RecordError(
                    f"{folders} have other flights of policy {row.spec!r} in episode {overlap} of seed {row.run[2]}; "
                    "`rss-gym verify` says which is right"
                )
            if overlap == -1 or (overlap is None and row.shipped):
                twin = one
                break
        if twin is None:
            if same:
                notes.append(f"{row.key} and {same[0].key} have one hash and may be one policy or two; both are listed")
            kept.append(row)
        elif twin.run != row.run or row.record != twin.record:
            notes.append(f"{row.key} is left out: {twin.key} is the same policy{_why(twin, row)}")
    return kept, notes


def _differing(one: BoardRow, other: BoardRow) -> int | None:
    """The first common encounter whose flights differ, -1 if they are the same, None without a common encounter."""
    if one.run[1:3] != other.run[1:3]:
        return None
    n = min(len(one.costs), len(other.costs))
    unlike = one.min_separation_m[:n] != other.min_separation_m[:n]
    unlike |= one.costs.cost_m[:n] != other.costs.cost_m[:n]
    return int(np.argmax(unlike)) if unlike.any() else -1


def _why(twin: BoardRow, row: BoardRow) -> str:
    if twin.official and not row.official:
        return ", in an official run"
    if twin.run[-1] > row.run[-1]:
        return f", on {twin.run[-1]} encounters instead of {row.run[-1]}"
    return " on as many encounters"


def markup(rows: Sequence[BoardRow], sources: Sequence[Source], notes: Sequence[str]) -> str:
    """The page."""
    flown = {row.run[0] for row in rows}
    suites = [*(name for name in SUITES if name in flown), *sorted(flown - set(SUITES))]
    sections = []
    for name in suites:
        members = [row for row in rows if row.run[0] == name]
        sections.append(Section(f"Suite {name}", _suite(members, sources)))
    shown = sorted({row.record for row in rows})
    records = _records([(number, sources[number - 1]) for number in shown])
    if notes:
        records += '<ul class="note">\n' + "".join(f"<li>{text(note)}</li>\n" for note in notes) + "</ul>"
    sections.append(Section("Records", records))
    lead = (
        f'<p class="lead">{len(rows)} policies of {len(shown)} records. Every score was recomputed from the record\'s '
        "episode table when this page was made; <code>rss-gym verify</code> flies the episodes again.</p>\n"
        f'<p class="note">{RANKING}</p>'
    )
    return render("Leaderboard", lead, sections)


def _suite(rows: Sequence[BoardRow], sources: Sequence[Source]) -> str:
    parts = []
    official_rows = [row for row in rows if row.official]
    others = sorted((row for row in rows if not row.official), key=lambda row: (-row.run[3], row.run[1:3]))
    if official_rows:
        parts.append(f"<h3>Official runs: {_encounters(official_rows[0])}</h3>\n" + _levels(official_rows, sources))
    else:
        parts.append('<p class="text">No official run.</p>\n')
    for _, group in itertools.groupby(others, key=lambda row: row.run):
        members = list(group)
        parts.append(f"<h3>Other runs: {_encounters(members[0])}</h3>\n" + _levels(members, sources))
    return "".join(parts)


def _encounters(row: BoardRow) -> str:
    _, split, seed, episodes = row.run
    return f"{episodes:,} encounters of split {text(split)}, seed {seed}"


def _levels(rows: Sequence[BoardRow], sources: Sequence[Source]) -> str:
    parts = []
    for level in get_args(Information):
        members = [row for row in rows if row.information == level]
        if members:
            parts.append(f'<p class="text">Information <strong>{text(level)}</strong>: {text(LEVELS[level])}</p>\n')
            parts.append(_table(members, sources))
    return "".join(parts)


def _table(rows: Sequence[BoardRow], sources: Sequence[Source]) -> str:
    by_key, shown = {row.key: row for row in rows}, rows[0].shown
    alphabet = {key: index for index, key in enumerate(sorted(by_key))}
    places = ranking.rank(row.candidate() for row in rows)
    lines = ""
    for place in places:
        row = by_key[place.name]
        link = f'<a href="{text(sources[row.record - 1].copy)}/{SCORES}">record {row.record}</a>'
        why = f'; <strong class="fault">{text(place.why_not)}</strong>' if place.why_not else ""
        lines += (
            f"<tr{barred(place)}>{place_cell(place)}"
            f'<th scope="row" class="words" data-value="{alphabet[row.key]}">{text(row.name)}<span class="unit">{link}'
            f"{why}</span></th>{cell(row.metrics.get(shown[0]))}{difference(place)}"
            + "".join(cell(row.metrics.get(name)) for name in shown[1:])
            + "</tr>\n"
        )
    headings = (
        f'<th scope="col">place</th><th scope="col" class="words">policy</th>{heading(shown[0])}{FIRST}'
        + "".join(heading(name) for name in shown[1:])
    )
    return scrolled(
        f'<table class="sortable policies"><thead><tr>{headings}</tr></thead>\n<tbody>\n{lines}</tbody></table>'
    )


def _records(shown: Sequence[tuple[int, Source]]) -> str:
    lines = ""
    for number, source in shown:
        files = ", ".join(
            f'<a href="{text(source.copy)}/{text(file)}">{text(file.removeprefix(TABLES + "/"))}</a>'
            for file in source.files
        )
        versions = ", ".join(f"{name} {version}" for name, version in source.versions.items())
        lines += (
            f'<tr><td>{number}</td><td class="words">{text(source.suite)}<span class="unit">'
            f"{text(source.suite_hash[:12])}</span></td><td>{source.seed}</td><td>{source.episodes:,}</td>"
            f'<td class="words">{"yes" if source.official else "no"}</td><td class="words">{text(versions)}</td>'
            f'<td class="words">{files}</td></tr>\n'
        )
    numbers = ("record", "seed", "encounters")
    headings = "".join(
        f'<th scope="col">{name}</th>' if name in numbers else f'<th scope="col" class="words">{name}</th>'
        for name in ("record", "suite", "seed", "encounters", "official", "versions", "files")
    )
    return scrolled(f'<table class="policies"><thead><tr>{headings}</tr></thead>\n<tbody>\n{lines}</tbody></table>')
