"""A season: what is flown, and the sealed seeds by commit and reveal.

`new` draws a secret and publishes its SHA-256. The sealed seed of a suite is HMAC-SHA256 of its name with the secret,
so nobody knows it before the season closes, and the board cannot choose it afterwards. `close` writes the secret into
the season's file; from then on anyone can fly the sealed encounters.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import hmac
import json
import os
import re
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rss_gym.arguments import count
from rss_gym.core import SEED_LIMIT
from rss_gym.eval.evaluate import is_name
from rss_gym.eval.reading.plain import RecordError, checked, parse, read_file
from rss_gym.eval.suites import Suite, find
from rss_gym.files import write_bytes, write_text
from rss_gym.params import ParamsError
from rss_gym.schema import HEX, Kind, Schema, listed, matching, optional, version, whole

FORMAT = 1
BYTES_MAX = 2**20
SECRET = ".secret"  # ending of the file beside the season's that holds the secret until it closes

_COUNT = whole(1, 10**6)
_FIELDS: Schema = {
    "format": version(FORMAT),
    "name": matching("[a-z0-9-]{1,40}", "1 to 40 of a-z, 0-9 and '-'"),
    "suites": listed(1, 100, "a list of 1 to 100 suites"),
    "commitment": HEX,
    "secret": optional(HEX, "null, or 64 hex digits once the season is closed"),
}
_SUITE: Schema = {"name": Kind(is_name, "a suite"), "hash": HEX, "public": _COUNT, "sealed": _COUNT}


@dataclass(frozen=True)
class Flown:
    """One suite of a season: how many of its own encounters, and how many sealed ones, are flown."""

    name: str
    hash: str
    public: int
    sealed: int

    def suite(self) -> Suite:
        """Its definition.

        Raises
        ------
        ParamsError
            If that is not the season's any more.
        """
        suite = find(self.name)
        if suite.hash != self.hash:
            raise ParamsError(
                f"suite {self.name!r} is not defined as in the season ({suite.hash[:12]} instead of {self.hash[:12]}); "
                "a changed rule needs a new season, which flies all entries again"
            )
        return suite


@dataclass(frozen=True)
class Season:
    """What a season's file says."""

    name: str
    suites: tuple[Flown, ...]
    commitment: str
    secret: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {
            "format": FORMAT,
            **dataclasses.asdict(self),
            "suites": [dataclasses.asdict(one) for one in self.suites],
        }


def new(path: str | os.PathLike[str], name: str, suites: list[str], public: int, sealed: int) -> Season:
    """Write a new season, and beside it the secret, which must not be published before it closes.

    Parameters
    ----------
    path : path
        New file.
    name : str
    suites : list of str
        Names; `highway-v0:100` flies at most so many public and so many sealed encounters of this suite.
    public, sealed : int
        Encounters of the other suites.

    Raises
    ------
    ParamsError
        For an unknown suite, a number out of range, or a file that exists.
    """
    target = Path(path)
    for file in (target, _secret_file(target)):
        if file.exists():
            raise ParamsError(f"season {str(file)!r} exists; a season's secret is drawn once")
    secret = secrets.token_hex(32)
    flown = tuple(_flown(one, public, sealed) for one in suites)
    season = Season(name, flown, hashlib.sha256(bytes.fromhex(secret)).hexdigest())
    _checked(str(target), season.to_dict())
    write_private(_secret_file(target), secret.encode())
    _write(target, season)
    return season


def _flown(text: str, public: int, sealed: int) -> Flown:
    """A suite by its name, with a number of its own after a colon or without."""
    name, colon, number = text.partition(":")
    if colon:
        try:
            public = sealed = count(number)
        except argparse.ArgumentTypeError as error:
            raise ParamsError(f"suite {text!r}: the number of encounters {error}") from error
    suite = find(name)
    return Flown(suite.name, suite.hash, min(public, suite.episodes), sealed)


def load(path: str | os.PathLike[str]) -> Season:
    """The season in a file.

    Raises
    ------
    RecordError
        For anything else; also if a secret in it is not the one of the commitment.
    """
    return _checked(str(path), parse(read_file(Path(path), BYTES_MAX), str(path)))


def _checked(file: str, content: Any) -> Season:
    fields = checked(file, "", content, _FIELDS)
    suites = [Flown(**checked(file, f"suites[{i}]", one, _SUITE)) for i, one in enumerate(fields["suites"])]
    if len({one.name for one in suites}) < len(suites):
        raise RecordError(f"{file}: suites names one twice")
    season = Season(fields["name"], tuple(suites), fields["commitment"], fields["secret"])
    if season.secret is not None:
        check_secret(season, season.secret, file)
    return season


def secret_of(path: str | os.PathLike[str]) -> str:
    """The secret of a season, from its file if it is closed, else from the file beside it.

    Raises
    ------
    RecordError
        If there is none, or another one than was committed to.
    """
    season, file = load(path), _secret_file(Path(path))
    secret = season.secret or read_file(file, 64).decode("ascii", "replace")
    check_secret(season, secret, str(file))
    return secret


def check_secret(season: Season, secret: str, file: str) -> None:
    """Refuse a secret that is not the one committed to."""
    if re.fullmatch("[0-9a-f]{64}", secret) is None or not hmac.compare_digest(
        hashlib.sha256(bytes.fromhex(secret)).hexdigest(), season.commitment
    ):
        raise RecordError(f"{file}: the secret is not the one of the season's commitment {season.commitment[:12]}...")


def close(path: str | os.PathLike[str]) -> Season:
    """Reveal the secret in the season's file."""
    season = dataclasses.replace(load(path), secret=secret_of(path))
    _write(Path(path), season)
    return season


def sealed_seed(secret: str, suite: str) -> int:
    """The seed of a suite's sealed encounters: the first 8 bytes of HMAC-SHA256(secret, suite), modulo 2**63."""
    digest = hmac.new(bytes.fromhex(secret), suite.encode(), hashlib.sha256).digest()
    return int.from_bytes(digest[:8], "big") % SEED_LIMIT


def write_private(path: Path, content: bytes) -> None:
    """Write a file that only its owner may read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    before = os.umask(0o077)
    try:
        write_bytes(path, content)
    finally:
        os.umask(before)


def _secret_file(path: Path) -> Path:
    return path.with_name(path.name + SECRET)


def _write(path: Path, season: Season) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(season.to_dict(), indent=1) + "\n")
