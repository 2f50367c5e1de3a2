"""Which entries are flown: one a submitter and suite, each policy once, and no two names that look alike."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rss_gym.eval.board.entry import ALL, Submission, read
from rss_gym.eval.board.names import folded
from rss_gym.eval.board.pack import PACKED, unpack
from rss_gym.params import ParamsError

ENTRIES_MAX = 1000


@dataclass(frozen=True)
class Gathered:
    """The entries that count, and of the others the folder and why, one sentence each."""

    entries: tuple[Submission, ...]
    refused: tuple[str, ...]


def gather(
    folder: str | os.PathLike[str], known: Iterable[tuple[str, str, str]] = (), unpacked: Path | None = None
) -> Gathered:
    """Read the entries in `folder`, folders or packed; one that is refused does not concern the others.

    They are taken in the order of their names, which are given to them as they arrive: a date is a claim.

    Parameters
    ----------
    folder : path
    unpacked : Path, optional
        Where packed entries are unpacked; without it they are refused.
    known : iterable of (name, author, policy hash)
        The entries that the board has flown already: they were there first.

    Raises
    ------
    ParamsError
        If the folder cannot be read.
    """
    try:
        places = sorted(path for path in Path(folder).iterdir() if not path.name.startswith("."))
    except OSError as error:
        raise ParamsError(f"folder of entries {str(folder)!r} cannot be read: {error}") from error
    refused = [f"{path}: only the first {ENTRIES_MAX} folders are read" for path in places[ENTRIES_MAX:]]
    read_entries: list[Submission] = []
    for path in places[:ENTRIES_MAX]:
        try:
            read_entries.append(read(unpack(path, unpacked) if unpacked and path.name.endswith(PACKED) else path))
        except ParamsError as error:
            refused.append(str(error))
    latest: dict[tuple[str, str], Submission] = {}
    for entry in read_entries:
        key = folded(entry.author), entry.suite
        if key in latest:
            refused.append(_why(latest[key], f"{entry.author!r} has a later one for {entry.suite}, which counts"))
        latest[key] = entry
    for key, entry in list(latest.items()):
        if key[1] != ALL and (key[0], ALL) in latest:
            refused.append(_why(entry, f"{entry.author!r} has one for all suites; one a submitter and suite counts"))
            del latest[key]
    owners = {folded(name): author for name, author, _ in known}
    policies = {hashed: (name, author) for name, author, hashed in known}
    kept = []
    for entry in [one for one in read_entries if one in latest.values()]:
        owner = owners.setdefault(folded(entry.name), entry.author)
        first, author = policies.setdefault(entry.policy_hash, (entry.name, entry.author))
        if folded(owner) != folded(entry.author):
            refused.append(_why(entry, f"its name {entry.name!r} reads like one of {owner!r}; choose another"))
        elif folded(author) != folded(entry.author):
            refused.append(_why(entry, f"it is the policy of {first!r} by {author!r}, bit for bit"))
        else:
            kept.append(entry)
    return Gathered(tuple(kept), tuple(refused))


def _why(entry: Submission, why: str) -> str:
    return f"{entry.folder}: {why}"
