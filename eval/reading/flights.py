"""The flights that a record keeps for its page, `flights.json`."""

from __future__ import annotations

from typing import Any

from rss_gym.eval.reading.plain import RecordError, checked, parse, read_file
from rss_gym.eval.reading.record import Record
from rss_gym.eval.report.flights import FLIGHTS, FORMAT, Flown
from rss_gym.schema import Kind, Schema, listed, one_of, optional, real, table, truth, version, whole

BYTES_MAX = 32 * 2**20
FLIGHTS_MAX = 1000
DECISIONS_MAX, OTHERS_MAX = 100_000, 500
DECIMETRES_MAX = 10**9


DECIMETRES = whole(-DECIMETRES_MAX, DECIMETRES_MAX)


def _column(length: int, gaps: bool = True) -> Kind:
    """So many whole numbers, with nulls between them where `gaps` allows it."""
    words = f"a list of {length} whole numbers{' or nulls' if gaps else ''}"
    return listed(length, length, words, optional(DECIMETRES) if gaps else DECIMETRES)


def _is_clock(value: Any) -> bool:
    return listed(1, DECISIONS_MAX, "", real(0.0)).test(value) and bool(value == sorted(value))


DOCUMENT: Schema = {
    "format": version(FORMAT),
    "flights": listed(0, FLIGHTS_MAX, f"a list of at most {FLIGHTS_MAX} flights"),
    "failed": listed(0, FLIGHTS_MAX, "a list of sentences", Kind(lambda value: isinstance(value, str), "")),
}


def _flight(record: Record) -> Schema:
    first = record.first_episode
    return {
        "policy": one_of([policy.name for policy in record.policies]),
        "episode": whole(first, first + record.episodes - 1),
        "same": truth(),
        "own": table("a table"),
        "intruders": listed(1, OTHERS_MAX, f"a list of 1 to {OTHERS_MAX} tables"),
        "least": listed(0, DECISIONS_MAX, "a list of whole numbers"),
        "times": Kind(_is_clock, f"a list of 1 to {DECISIONS_MAX} times that do not fall"),
        "collision": truth(),
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
