"""What others send against an entry: encounters on which it does worse than its row says, flown again and listed."""

from __future__ import annotations

import hashlib
import os
import tomllib
from pathlib import Path
from typing import Any

from rss_gym import encounters
from rss_gym.core import SEED_LIMIT
from rss_gym.eval.board import chain, verdict
from rss_gym.eval.board.entry import DATE, POLICY, read
from rss_gym.eval.board.fly import ENTRIES, Places, Runner, held
from rss_gym.eval.board.limits import Job, fly_limited
from rss_gym.eval.board.signing import private_key
from rss_gym.eval.budget import refuse_costly
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.reading.plain import RecordError, checked, read_file
from rss_gym.eval.records import table_digest
from rss_gym.eval.suites import SUITES
from rss_gym.params import PRESETS_FOLDER, ParamsError
from rss_gym.schema import Kind, Schema, line, one_of, version, whole

KIND = "break"
FORMAT = 1
BYTES_MAX = 64 * 1024
COUNT_MAX = 10_000
DRAWN_MIN = 100  # encounters from number 0 on, if they are not named one by one


def _is_numbers(value: Any) -> bool:
    if type(value) is int:
        return DRAWN_MIN <= value <= COUNT_MAX
    whole = isinstance(value, list) and all(type(one) is int and 0 <= one < SEED_LIMIT for one in value)
    return whole and 1 <= len(value) <= COUNT_MAX and len(set(value)) == len(value)


_FIELDS: Schema = {
    "format": version(FORMAT),
    "entry": line(80, words="the name of an entry"),
    "suite": Kind(lambda value: isinstance(value, str) and value in SUITES, "the name of a suite"),
    "author": line(80),
    "date": DATE,
    "seed": whole(0, SEED_LIMIT - 1, "a whole number in [0, 2**63)"),
    "episodes": Kind(_is_numbers, f"a list of numbers, or how many from 0 on, {DRAWN_MIN} to {COUNT_MAX}"),
    "family": one_of(["", *encounters.FAMILIES.shipped], 'a family of encounters, or ""'),
    "channel": one_of(["", *(file.stem for file in PRESETS_FOLDER.glob("*.toml"))], 'a preset of the radio, or ""'),
}


def fly(
    file: str | os.PathLike[str],
    season_file: str | os.PathLike[str],
    out: str | os.PathLike[str],
    runner: Runner = fly_limited,
) -> dict[str, Any]:
    """Fly the encounters of a file and append a line that lists them beside the entry.

    Returns
    -------
    dict
        The line; `worse` says whether the whole interval of the cost lies above that of the entry's row.

    Raises
    ------
    RecordError
        If the file is not one, or names an entry that has no row.
    ParamsError
        If such a world cannot be flown.
    """
    fields = _read(Path(file))
    places = Places.of(out, season_file)
    row = _row(places, fields)
    suite = SUITES[fields["suite"]]
    changes: dict[str, Any] = {}
    if fields["family"]:
        changes["families"] = fields["family"]
    if fields["channel"]:
        changes["channel"] = fields["channel"]
    world = suite.changed(**changes)
    refuse_costly(world.params)
    named = isinstance(fields["episodes"], list)
    numbers = tuple(fields["episodes"]) if named else ()
    count = len(numbers) or fields["episodes"]
    table = runner(
        Job(
            suite.name,
            suite.hash,
            _spec(places, row),
            row["entry"]["name"],
            suite.split,
            fields["seed"],
            0,
            count,
            tuple(changes.items()),
            numbers,
        )
    )
    cost = Costs.of(table, Prices.of(world.params)).interval()
    of_row = row["public"]["metrics"]["cost_m"]
    worse = cost.low is not None and of_row["high"] is not None and cost.low > of_row["high"]
    line = {
        "kind": KIND,
        "entry": fields["entry"],
        "entry_hash": row["entry_hash"],
        "suite": suite.name,
        "suite_hash": suite.hash,
        "season": row["season"],
        "author": fields["author"],
        "date": fields["date"].isoformat(),
        "seed": fields["seed"],
        "named": named,
        "count": count,
        "family": fields["family"],
        "channel": fields["channel"],
        "file_sha256": hashlib.sha256(read_file(Path(file), BYTES_MAX)).hexdigest(),
        "table_sha256": table_digest(table),
        "cost_m": {"value": cost.value, "low": cost.low, "high": cost.high},
        "collisions": int(table["collision"].sum()),
        "worse": bool(worse or (named and cost.value > (of_row["high"] or of_row["value"]))),
    }
    if not line["worse"]:
        return line
    with held(places.board):
        return chain.append(places.lines, line, private_key(places.key))


def _read(file: Path) -> dict[str, Any]:
    try:
        content = tomllib.loads(read_file(file, BYTES_MAX).decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordError(f"{file} is not TOML: {error}") from error
    return checked(str(file), "", content, _FIELDS)


def _row(places: Places, fields: dict[str, Any]) -> dict[str, Any]:
    """The newest line of the entry on the suite."""
    for row in reversed(chain.read(places.lines)):
        if row["kind"] == verdict.KIND and (row["entry"]["name"], row["suite"]) == (
            fields["entry"],
            fields["suite"],
        ):
            if row["failed"]:
                raise RecordError(f"entry {fields['entry']!r} was not flown to its end on {fields['suite']}")
            return row
    raise RecordError(f"entry = {fields['entry']!r} has no row on {fields['suite']}")


def _spec(places: Places, row: dict[str, Any]) -> str:
    """What the policy of a row is built by: its name, or the board's copy of its files."""
    if not row["entry"]["link"]:
        return str(row["entry"]["policy"])
    kept = read(places.board / ENTRIES / row["entry_hash"][:16])
    if kept.hash != row["entry_hash"]:
        raise ParamsError(f"{places.board / ENTRIES / row['entry_hash'][:16] / POLICY} is not what was flown")
    return kept.spec
