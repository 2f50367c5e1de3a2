"""The flights that a record keeps for its page, `flights.json`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rss_gym.eval.reading.plain import Checks, RecordError, checked, parse, read_file
from rss_gym.eval.reading.record import Record
from rss_gym.eval.report.flights import FLIGHTS, FORMAT, Flown

BYTES_MAX = 32 * 2**20
FLIGHTS_MAX = 1000
DECISIONS_MAX, OTHERS_MAX = 100_000, 500
DECIMETRES_MAX = 10**9


def _is_number(value: Any) -> bool:
    return type(value) is int and abs(value) <= DECIMETRES_MAX


def _column(length: int, gaps: bool = True) -> tuple[Callable[[Any], bool], str]:
    """A check of a list of so many whole numbers, with nulls between them where `gaps` allows it."""
    return (
        lambda value: (
            isinstance(value, list)
            and len(value) == length
            and all(_is_number(item) or (gaps and item is None) for item in value)
        ),
        f"a list of {length} whole numbers{' or nulls' if gaps else ''}",
    )


def _is_clock(value: Any) -> bool:
    if not isinstance(value, list) or not 1 <= len(value) <= DECISIONS_MAX:
        return False
    return all(type(item) in (int, float) for item in value) and value == sorted(value) and value[0] >= 0


DOCUMENT: Checks = {
    "format": (lambda value: type(value) is int and value == FORMAT, f"{FORMAT}, which this version reads"),
    "flights": (
        lambda value: isinstance(value, list) and len(value) <= FLIGHTS_MAX,
        f"a list of at most {FLIGHTS_MAX} flights",
    ),
    "failed": (
        lambda value: isinstance(value, list) and all(isinstance(item, str) for item in value),
        "a list of sentences",
    ),
}


def _flight(record: Record) -> Checks:
    names = [policy.name for policy in record.policies]
    numbers = range(record.first_episode, record.first_episode + record.episodes)
    return {
        "policy": (lambda value: value in names, f"one of the record's policies, {', '.join(names)[:200]}"),
        "episode": (
            lambda value: type(value) is int and value in numbers,
            f"a whole number in [{numbers[0]}, {numbers[-1]}]",
        ),
        "same": (lambda value: isinstance(value, bool), "true or false"),
        "own": (lambda value: isinstance(value, dict), "a table"),
        "intruders": (
            lambda value: isinstance(value, list) and 1 <= len(value) <= OTHERS_MAX,
            f"a list of 1 to {OTHERS_MAX} tables",
        ),
        "least": (lambda value: isinstance(value, list), "a list of whole numbers"),
        "times": (_is_clock, f"a list of 1 to {DECISIONS_MAX} times that do not fall"),
        "collision": (lambda value: isinstance(value, bool), "true or false"),
    }


def read_flights(record: Record) -> Flown | None:
    """The flights in the folder of a record; None where it has none.

    Raises
    ------
    RecordError
        If the file is not one that `rss_gym.eval.report.write` made for this record.
    """
    file = record.folder / FLIGHTS
    if not file.exists() and not file.is_symlink():
        return None
    content = checked(str(file), "", parse(read_file(file, BYTES_MAX), str(file)), DOCUMENT)
    checks, axes = _flight(record), 2 if record.params.encounter.planar else 3
    flights: dict[tuple[str, int], dict[str, Any]] = {}
    for index, item in enumerate(content["flights"]):
        where = f"flights[{index}]"
        flight = dict(checked(str(file), where, item, checks))
        n = len(flight["times"])
        vector, scalar = _column(axes * n), _column(n)
        whole = {"least": _column(n, gaps=False)}
        checked(str(file), where, {"least": flight["least"]}, whole)
        checked(str(file), f"{where}.own", flight["own"], dict.fromkeys(("position", "planned", "way_point"), vector))
        columns = dict.fromkeys(("position", "message"), vector) | dict.fromkeys(("range", "std", "zone"), scalar)
        for k, other in enumerate(flight["intruders"]):
            checked(str(file), f"{where}.intruders[{k}]", other, columns | {"warning": _column(n, gaps=False)})
        key = flight.pop("policy"), flight.pop("episode")
        if key in flights:
            raise RecordError(f"{file}: {where} is of policy {key[0]!r}, episode {key[1]}, which is given twice")
        flights[key] = flight
    return Flown(flights, tuple(content["failed"]))
