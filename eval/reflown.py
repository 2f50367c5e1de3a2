"""Whether the flights that a record keeps for its page are those that its policies fly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rss_gym.eval.episodes import PolicyError
from rss_gym.eval.policies import Entry
from rss_gym.eval.reading import Record, read_flights
from rss_gym.eval.report.replay import again

FLIGHTS_MIN = 10

Key = tuple[str, int]


def kept(record: Record) -> dict[Key, dict[str, Any]]:
    """The flights that a record keeps, by policy and number of the encounter; none without `flights.json`.

    Raises
    ------
    RecordError
        If the file is not one of this record.
    """
    flown = read_flights(record)
    return {} if flown is None else flown.flights


def sampled(keys: Sequence[Key], every: bool, seed: int) -> list[Key]:
    """Flights to fly again: all, or `FLIGHTS_MIN` of them, drawn by a seed."""
    if every or len(keys) <= FLIGHTS_MIN:
        return list(keys)
    places = np.random.default_rng(seed).choice(len(keys), FLIGHTS_MIN, replace=False)
    return [keys[place] for place in sorted(places.tolist())]


def differences(record: Record, entry: Entry, episode: int, flight: dict[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Fields of a flight that are not those of the same encounter flown again: path, recorded and found value."""
    row = record[entry.name].table[episode - record.first_episode]
    try:
        found = again(entry, record.split, record.seed, row)
    except PolicyError as error:
        yield "flight", "flown to its end", str(error)
        return
    yield from _unlike("flight", flight, found)


def _unlike(path: str, recorded: Any, found: Any) -> Iterator[tuple[str, Any, Any]]:
    """The fields that differ; of a list of numbers the first place that does."""
    if isinstance(found, dict):  # the reader has found the same fields in both
        for name in found:
            yield from _unlike(f"{path}.{name}", recorded[name], found[name])
    elif isinstance(found, list) and len(recorded) != len(found):
        yield f"length of {path}", len(recorded), len(found)
    elif isinstance(found, list) and found and isinstance(found[0], dict):
        for place, (one, other) in enumerate(zip(recorded, found, strict=True)):
            yield from _unlike(f"{path}[{place}]", one, other)
    elif isinstance(found, list):
        unlike = [place for place, (one, other) in enumerate(zip(recorded, found, strict=True)) if one != other]
        if unlike:
            yield f"{path}[{unlike[0]}]", recorded[unlike[0]], found[unlike[0]]
    elif recorded != found:
        yield path, recorded, found
