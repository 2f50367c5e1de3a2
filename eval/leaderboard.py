"""Merges records into one page of ranked tables, each of them self-reported: what others say that they have flown.

Metrics are recomputed from the records' tables and a sample of encounters, drawn by chance, is flown again. A record in
which anything differs is set aside and named, and the page is made of the others; what one record says never decides
about another. A policy that cannot be flown again has no place, since its table is a claim. Only `rss-gym board` makes
rows that nobody has reported himself.

For each suite the runs of all its encounters come first, one table a level of information. Other runs stand apart, and
only those over the same encounters share a table, since the ranking compares policies encounter by encounter.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np

from rss_gym import baselines
from rss_gym.baselines.policy_files import DOCUMENT, WEIGHTS
from rss_gym.core import NotFiniteError
from rss_gym.eval import ranking
from rss_gym.eval.budget import refuse_costly
from rss_gym.eval.columns import columns_of
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.policies import innermost
from rss_gym.eval.reading import Policy, Record, RecordError, definition, load
from rss_gym.eval.records import SCORES, TABLES
from rss_gym.eval.report.tables import FIRST, barred, column
from rss_gym.eval.suites import SUITES
from rss_gym.eval.text import difference
from rss_gym.eval.text import number as place_of
from rss_gym.eval.verify import differing, examine, official
from rss_gym.files import check_new, new_folder
from rss_gym.pages import page
from rss_gym.pages.markup import renderer
from rss_gym.pages.page import Section
from rss_gym.pages.table import Cell, Column, Row, Table
from rss_gym.params import Information, ParamsError

render = renderer(__file__)
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
    "deviation. A policy with a fault (an action that is not finite) is not ranked and shown in red; so is one that "
    "could not be flown again, because its table is a claim."
)
CLAIM = "not ranked: it cannot be flown again here, so its table is a claim"
ASIDE = "In these records something differs, or they cannot be read. Nothing of them is shown above."
NOT_FLOWN = "not flown"


class Encounters(NamedTuple):
    """What was flown: rows of one table share it."""

    suite: str
    suite_hash: str
    split: str
    seed: int
    episodes: int


@dataclass(frozen=True, eq=False)
class BoardRow:
    """One policy of one record, without its table."""

    record: int  # place in the list of records, from 1
    run: Encounters
    whole: bool  # all encounters of a suite as it is defined
    name: str
    spec: str
    hash: str
    information: str
    metrics: dict[str, Estimate]
    faults: int
    costs: Costs
    rows: np.ndarray  # a digest of each whole row of the table
    flown: str  # `all`, `sample` or `not flown`: how much of it was flown again
    own_files: bool  # the record brings the policy's files
    shown: tuple[str, ...]  # metrics, that of the ranking first

    @property
    def key(self) -> str:
        """Unique among all rows."""
        return f"{self.name} (record {self.record})"

    @property
    def shipped(self) -> bool:
        """Whether the specification alone says which policy it is."""
        return not self.own_files and baselines.is_known(innermost(self.spec))

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
    whole: bool
    versions: dict[str, str]


@dataclass(frozen=True)
class Site:
    """What `build` made, what a reader should know about the merge, and the records set aside, each with why."""

    page: Path
    notes: tuple[str, ...]
    quarantined: tuple[str, ...] = ()


def build(folders: Sequence[str | os.PathLike[str]], out: str | os.PathLike[str], seed: int | None = None) -> Site:
    """Write the new folder `out` with `index.html` and a copy of each record shown.

    Parameters
    ----------
    folders : sequence of path
        Records. One that is not intact, whose metrics are not those of its tables, whose sample of encounters flies
        otherwise, or that is too costly to fly is set aside and named on the page.
    out : path
    seed : int, optional
        Draws the samples; default: by chance.

    Raises
    ------
    RecordError
        If no record is left.
    ParamsError
        If `out` exists or cannot be written.
    """
    out = check_new(out)
    sources: dict[int, Source] = {}
    rows: list[BoardRow] = []
    quarantined: list[str] = []
    for number, folder in enumerate(folders, 1):
        try:
            record = load(folder)
            status = _checked(record, seed)
        except (ParamsError, NotFiniteError) as error:
            quarantined.append(str(error) if str(folder) in str(error) else f"{folder}: {error}")
            continue
        sources[number] = _source(record, number)
        rows += [_row(record, policy, number, status[policy.name]) for policy in record.policies]
    for number, why in contradictions(rows, sources).items():
        quarantined.append(why)
        rows = [row for row in rows if row.record != number]
    if not rows:
        raise RecordError("; ".join(quarantined) or "a leaderboard needs at least one record")
    kept, notes = merge(rows)
    with new_folder(out) as site:
        for number in sorted({row.record for row in kept}):
            source = sources[number]
            for file in source.files:
                target = site / source.copy / file
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source.folder / file, target)
        (site / PAGE).write_text(markup(kept, sources, notes, quarantined), encoding="utf-8")
    return Site(out / PAGE, tuple(notes), tuple(quarantined))


def _checked(record: Record, seed: int | None) -> dict[str, str]:
    """How much of each policy was flown again; refuses a record in which anything differs.

    Raises
    ------
    RecordError, NotFiniteError
    """
    _check(record)
    refuse_costly(record.params, [policy.spec for policy in record.policies])
    verdict = examine(record, seed=seed, progress=False)
    if verdict.differences:
        raise RecordError(f"{record.folder}: {verdict.differences[0]}; `rss-gym verify` lists all differences")
    return verdict.status


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


def _source(record: Record, number: int) -> Source:
    name = re.sub("[^A-Za-z0-9._-]+", "-", record.folder.resolve().name)[:80]
    return Source(
        folder=record.folder,
        copy=f"{RECORDS}/{number}-{name}",
        files=(
            SCORES,
            *(policy.file for policy in record.policies),
            *(f"{p.folder}/{name}" for p in record.policies if p.folder for name in (DOCUMENT, WEIGHTS)),
        ),
        suite=record.suite,
        suite_hash=record.suite_hash,
        seed=record.seed,
        episodes=record.episodes,
        whole=record.official,
        versions=record.versions,
    )


def _row(record: Record, policy: Policy, number: int, flown: str) -> BoardRow:
    return BoardRow(
        record=number,
        run=Encounters(record.suite, record.suite_hash, record.split, record.seed, record.episodes),
        whole=record.official,
        name=policy.name,
        spec=policy.spec,
        hash=policy.hash,
        information=policy.information,
        metrics=policy.metrics,
        faults=int(np.count_nonzero(policy.table["fault"])),
        costs=Costs.of(policy.table, Prices.of(record.params)),
        rows=_row_digests(policy.table),
        flown=flown,
        own_files=policy.folder is not None,
        shown=tuple(columns_of(record.params)),
    )


def _row_digests(table: np.ndarray) -> np.ndarray:
    """Sixteen bytes for each whole row. Shape (n, 16)."""
    rows = np.ascontiguousarray(table).view(np.uint8).reshape(len(table), table.dtype.itemsize)
    digests = b"".join(hashlib.blake2b(row.data, digest_size=16).digest() for row in rows)
    return np.frombuffer(digests, np.uint8).reshape(len(table), 16)


def contradictions(rows: Sequence[BoardRow], sources: Mapping[int, Source]) -> dict[int, str]:
    """Records that are wrong where two of them have other flights of one policy: the flight itself decides."""
    wrong: dict[int, str] = {}
    groups: dict[tuple[str, str, str, int], list[BoardRow]] = {}
    for row in rows:
        if row.flown != NOT_FLOWN:
            groups.setdefault((row.hash, row.run.suite_hash, row.run.split, row.run.seed), []).append(row)
    for members in groups.values():
        for one, other in itertools.combinations(members, 2):
            place = _differing(one, other)
            if place is None:
                continue
            for row in (one, other):
                if row.record in wrong:
                    continue
                record = load(sources[row.record].folder)
                found = differing(record, definition(record), row.name, [place])
                if found:
                    wrong[row.record] = f"{record.folder}: {found[0]}; `rss-gym verify` lists all differences"
    return wrong


def merge(rows: Iterable[BoardRow]) -> tuple[list[BoardRow], list[str]]:
    """A policy of the package once a suite, from its longest run; and what was left out or may be one policy.

    Of what a record brings itself, every row is listed: nobody's record takes the place of another's.
    """
    kept: list[BoardRow] = []
    notes: list[str] = []
    for row in sorted(rows, key=lambda row: (not row.whole, -row.run.episodes, row.record)):
        same = [one for one in kept if (one.run[:2], one.hash) == (row.run[:2], row.hash)]
        twin = next((one for one in same if one.shipped and row.shipped), None)
        if twin is None:
            if same:
                notes.append(f"{row.key} and {same[0].key} have one hash and may be one policy; both are listed")
            kept.append(row)
        elif twin.run != row.run or row.record != twin.record:
            notes.append(f"{row.key} is left out: {twin.key} is the same policy{_why(twin, row)}")
    return kept, notes


def _differing(one: BoardRow, other: BoardRow) -> int | None:
    """The first common encounter of which any column differs."""
    n = min(len(one.rows), len(other.rows))
    unlike = (one.rows[:n] != other.rows[:n]).any(axis=1)
    return int(np.argmax(unlike)) if unlike.any() else None


def _why(twin: BoardRow, row: BoardRow) -> str:
    if twin.whole and not row.whole:
        return ", on all encounters of the suite"
    if twin.run.episodes > row.run.episodes:
        return f", on {twin.run.episodes} encounters instead of {row.run.episodes}"
    return " on as many encounters"


def markup(
    rows: Sequence[BoardRow], sources: Mapping[int, Source], notes: Sequence[str], quarantined: Sequence[str] = ()
) -> str:
    """The page."""
    flown = {row.run.suite for row in rows}
    suites = [*(name for name in SUITES if name in flown), *sorted(flown - set(SUITES))]
    sections = []
    for name in suites:
        members = [row for row in rows if row.run.suite == name]
        sections.append(Section(f"Suite {name}", render("suite.html", runs=_runs(members, sources), levels=LEVELS)))
    shown = sorted({row.record for row in rows})
    records = _records([(number, sources[number]) for number in shown])
    sections.append(Section("Records", render("records.html", table=records, notes=notes)))
    if quarantined:
        sections.append(Section("Set aside", render("aside.html", why=ASIDE, quarantined=quarantined)))
    lead = render("leaderboard.html", policies=len(rows), records=len(shown), ranking=RANKING)
    return page.render("Leaderboard of self-reported records", lead, sections)


def _runs(rows: Sequence[BoardRow], sources: Mapping[int, Source]) -> list[tuple[str, dict[str, Table]]]:
    """Title of each run of a suite, the whole ones first, and its table of each level of information."""
    runs = []
    for whole, title in ((True, "All encounters of the suite"), (False, "Other runs")):
        members = sorted((row for row in rows if row.whole is whole), key=lambda row: (-row.run.episodes, row.run))
        for run, group in itertools.groupby(members, key=lambda row: row.run):
            listed = list(group)
            levels = {level: [row for row in listed if row.information == level] for level in get_args(Information)}
            tables = {level: _table(those, sources) for level, those in levels.items() if those}
            runs.append((f"{title}: {_encounters(run)}", tables))
    return runs


def _encounters(run: Encounters) -> str:
    known = run.suite in SUITES and SUITES[run.suite].hash == run.suite_hash
    other = "" if known else f", definition {run.suite_hash[:12]}, which is not the suite's"
    return f"{run.episodes:,} encounters of split {run.split}, seed {run.seed}{other}"


def _table(rows: Sequence[BoardRow], sources: Mapping[int, Source]) -> Table:
    by_key, shown = {row.key: row for row in rows}, rows[0].shown
    alphabet = {key: index for index, key in enumerate(sorted(by_key))}
    places = ranking.rank(row.candidate() for row in rows if row.flown != NOT_FLOWN)
    claims = sorted((row for row in rows if row.flown == NOT_FLOWN), key=lambda row: row.key)
    places += [ranking.Place(row.key, None, None, False, row.faults) for row in claims]
    lines = []
    for place in places:
        row = by_key[place.name]
        reasons = [place.why_not] * bool(row.faults) + [CLAIM] * (row.flown == NOT_FLOWN)
        small = render("policy.html", row=row, file=f"{sources[row.record].copy}/{SCORES}", reasons=reasons)
        first, *others = (row.metrics.get(name) for name in shown)
        name = Cell(row.name, alphabet[row.key], small=small)
        lines.append(Row([place_of(place), name, first, difference(place), *others], barred(place)))
    cost, *more = (column(name) for name in shown)
    columns = ["place", Column("policy", words=True, head=True), cost, FIRST, *more]
    return Table(columns, lines, "sortable policies")


def _records(shown: Sequence[tuple[int, Source]]) -> Table:
    lines = []
    for number, source in shown:
        names = {f"{source.copy}/{file}": file.removeprefix(TABLES + "/") for file in source.files}
        versions = ", ".join(f"{name} {version}" for name, version in source.versions.items())
        suite = Cell(source.suite, small=source.suite_hash[:12])
        whole, files = "yes" if source.whole else "no", Cell(render("files.html", names=names))
        lines.append([str(number), suite, str(source.seed), source.episodes, whole, versions, files])
    columns = [
        "record",
        Column("suite", words=True),
        "seed",
        Column("encounters", form=","),
        *(Column(title, words=True) for title in ("whole suite", "versions", "files")),
    ]
    return Table(columns, lines, "policies")
