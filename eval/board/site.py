"""The pages of a board, from `board.jsonl` by templates that escape whatever comes from outside; nothing is fetched."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from rss_gym.eval.board import breaks, chain, drawing, replays, season, tables, verdict
from rss_gym.eval.board.entry import read
from rss_gym.eval.board.fly import ENTRIES, Places
from rss_gym.eval.board.standing import standings
from rss_gym.eval.suites import SUITES, Suite
from rss_gym.files import new_folder, write_text
from rss_gym.pages import page
from rss_gym.pages.markup import renderer
from rss_gym.params import ParamsError

render = renderer(__file__)
REPLAYS = 2  # encounters of an entry on a suite
BY = {
    "families": "Cost of the sealed encounters by family, in m",
    "radios": "Cost of the sealed encounters by radio (index into the list of the world's channels), in m",
}


def build(
    board: str | os.PathLike[str],
    season_files: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    count: int = REPLAYS,
) -> Path:
    """Write the pages of a board into the new folder `out`.

    Parameters
    ----------
    board : path
        Folder with `board.jsonl`.
    season_files : sequence of path
        The files of the seasons shown, newest first.
    count : int
        Worst public encounters of each entry and suite that are flown again, drawn and played.

    Raises
    ------
    RecordError
        If the board's lines do not follow each other, or a season's file is not one.
    ParamsError
        If `out` exists.
    """
    lines = chain.read(Path(board) / chain.BOARD)
    if not lines:
        raise ParamsError(f"{Path(board) / chain.BOARD} has no lines; rss-gym board fly appends them")
    seasons = [(season.load(file), Places.of(board, file), Path(file)) for file in season_files]
    shown: list[dict[str, Any]] = []
    style = page.style() + Markup((Path(__file__).parent / "templates" / "board.css").read_text(encoding="utf-8"))
    with new_folder(out) as folder:
        (folder / ENTRIES).mkdir()

        def write(name: str, template: str, title: str, depth: str = "", **values: Any) -> None:
            write_text(folder / name, render(template, title=title, root=depth, style=style, **values))

        broken = [line for line in lines if line["kind"] == breaks.KIND]
        for current, places, file in seasons:
            suites: list[dict[str, Any]] = []
            for flown in current.suites:
                sealed = _sealed_seed(file, flown.name)
                levels = standings(lines, current.name, flown.name, places, sealed)
                name = f"{current.name}-{flown.name}.html"
                revealed = None if current.secret is None else sealed
                entries = sum(map(len, levels.values()))
                suites.append({"flown": flown, "levels": levels, "page": name, "seed": revealed, "count": entries})
                parts = {
                    level: {
                        "table": tables.level(rows),
                        "by": {title: tables.by(rows, kind) for kind, title in BY.items()},
                    }
                    for level, rows in levels.items()
                }
                write(
                    name,
                    "suite.html",
                    f"{flown.name}, season {current.name}",
                    season=current,
                    breaks=[line for line in broken if line["suite"] == flown.name],
                    summary=SUITES[flown.name].summary if flown.name in SUITES else "",
                    public_seed=SUITES[flown.name].seed if flown.name in SUITES else None,
                    flown=flown,
                    seed=revealed,
                    tables=parts,
                )
            shown.append({"season": current, "suites": suites, "table": tables.season(suites)})
        members = _by_entry(shown)
        for hashed, rows in members.items():
            line = rows[0]["row"].line
            write(
                f"{ENTRIES}/{hashed[:16]}.html",
                "entry.html",
                line["entry"]["name"],
                "../",
                line=line,
                table=tables.entry(rows),
                breaks=[one for one in broken if one["entry_hash"] == hashed],
                drawings=[
                    {"suite": suite.name, "cases": [drawing.encounter(case.number, case.own) for case in found]}
                    | {"page": _replays(folder, suite, line, found)}
                    for suite, line, found in _worst(Path(board), rows, count)
                ],
                bars=_bars(rows),
                files=_copied(Path(board), folder, hashed),
            )
        head = chain.head(Path(board) / chain.BOARD)
        write("index.html", "index.html", "Leaderboard", seasons=shown, head=head, key=lines[0]["public_key"])
        write("enter.html", "enter.html", "How to enter, and what is checked")
        shutil.copyfile(Path(board) / chain.BOARD, folder / chain.BOARD)
        write_text(folder / "board.json", json.dumps(_as_json(shown, head), indent=1, allow_nan=False) + "\n")
        write_text(folder / "feed.xml", render("feed.xml", lines=lines[::-1][:50], head=head))
    return Path(out) / "index.html"


def _sealed_seed(file: Path, suite: str) -> int | None:
    """The seed of the sealed encounters, where its secret is at hand."""
    try:
        return season.sealed_seed(season.secret_of(file), suite)
    except ParamsError:
        return None


def _by_entry(shown: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    members: dict[str, list[dict[str, Any]]] = {}
    for one in shown:
        for suite in one["suites"]:
            for rows in suite["levels"].values():
                for row in rows:
                    about = {"season": one["season"].name, "suite": suite["flown"].name, "page": suite["page"]}
                    members.setdefault(row.line["entry_hash"], []).append({"row": row, **about})
    return members


def _worst(
    board: Path, rows: list[dict[str, Any]], count: int
) -> Iterator[tuple[Suite, dict[str, Any], list[replays.Case]]]:
    """Suites of an entry with their lines and its worst public encounters, flown again."""
    for one in rows:
        line = one["row"].line
        if line["failed"] or not count or line["suite"] not in SUITES:
            continue
        spec = line["entry"]["policy"]
        try:
            if line["entry"]["link"]:
                spec = read(board / ENTRIES / line["entry_hash"][:16]).spec
            suite = SUITES[line["suite"]]
            found = replays.cases(suite, spec, line["public"]["worst"][:count])
        except ParamsError:
            continue
        if found:
            yield suite, line, found


def _replays(folder: Path, suite: Suite, line: dict[str, Any], found: list[replays.Case]) -> str:
    """Write the page that plays these encounters; its name."""
    name = f"{line['entry_hash'][:16]}-{line['season']}-{suite.name}.html"
    write_text(folder / ENTRIES / name, replays.page_of(suite, line, found))
    return name


def _bars(rows: list[dict[str, Any]]) -> dict[str, Markup]:
    """Costs by family of each suite that the entry was flown on to its end."""
    lines = [one["row"].line for one in rows if not one["row"].line["failed"]]
    return {line["suite"]: drawing.bars(line["public"]["families"], line["sealed"]["families"]) for line in lines}


def _copied(board: Path, folder: Path, hashed: str) -> list[str]:
    """Copies of an entry's files, as the board keeps them, and their places from the entry's page."""
    source = board / ENTRIES / hashed[:16]
    if not re.fullmatch("[0-9a-f]{64}", hashed) or not source.is_dir():
        return []
    shutil.copytree(source, folder / ENTRIES / hashed[:16])
    files = sorted(path for path in (folder / ENTRIES / hashed[:16]).rglob("*") if path.is_file())
    return [path.relative_to(folder / ENTRIES).as_posix() for path in files]


def _as_json(shown: list[dict[str, Any]], head: str) -> dict[str, Any]:
    """What the tables show, for programs."""
    seasons = []
    for one in shown:
        tables = [
            {
                "suite": suite["flown"].name,
                "information": level,
                "rows": [
                    {
                        "place": row.place,
                        "entry": row.line["entry"]["name"],
                        "author": row.line["entry"]["author"],
                        "entry_hash": row.line["entry_hash"],
                        "why_not": row.why_not,
                        "front": row.front,
                        "sealed": None if row.line["failed"] else row.line["sealed"]["metrics"],
                        "public": None if row.line["failed"] else row.line["public"]["metrics"],
                        "gap_m": None if row.line["failed"] else row.line["gap_m"],
                        "alarm": row.alarm,
                    }
                    for row in rows
                ],
            }
            for suite in one["suites"]
            for level, rows in suite["levels"].items()
        ]
        seasons.append({"season": one["season"].to_dict(), "tables": tables})
    return {"head": head, "rules": verdict.RULES, "seasons": seasons}
