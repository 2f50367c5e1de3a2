"""Reads a record that may come from a stranger: bounded in memory and time, every field checked, nothing executed.

`scores.json` is checked against the lists below; a table is read only after its zip directory and array headers have
been found to be those of the record's episodes, so that no size stated in a file is ever believed.
"""

from __future__ import annotations

import json
import math
import os
import re
import reprlib
import stat
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, get_args

import numpy as np

from rss_gym.core import SEED_LIMIT, SPLITS
from rss_gym.encounters import chosen
from rss_gym.eval.evaluate import NAME_MAX, is_name
from rss_gym.eval.metrics import METRICS, Estimate
from rss_gym.eval.records import SCHEMA, SCORES, TABLES, table_digest
from rss_gym.eval.road.suites import SUITES as ROADS
from rss_gym.eval.table import TABLE
from rss_gym.eval.workers import NOMINAL
from rss_gym.params import Params, ParamsError, Track, suggestion

SCORES_BYTES_MAX = 8 * 2**20
TABLE_BYTES_MAX = 2**30
TABLES_BYTES_MAX = 4 * 2**30
EPISODES_MAX = TABLE_BYTES_MAX // TABLE.itemsize
DEPTH_MAX = 16
POLICIES_MAX = 1000
CHANNELS_MAX = 64
SPEC_MAX = 1000

# What zip and array headers may add to a table's rows, with room to spare.
_OVERHEAD_BYTES = 2**16
_HEADER_BYTES_MAX = 1024
_TIE_M = 1e-9  # two ways of rounding a separation


class RecordError(ParamsError):
    """A record that is not one, or not intact; the sentence names file, field, value and what would be right."""


@dataclass(frozen=True)
class Policy:
    """One policy of a record."""

    name: str
    spec: str
    hash: str
    track: str
    metrics: dict[str, Estimate]
    file: str  # of the table, below the record's folder
    table_sha256: str
    table: np.ndarray


@dataclass(frozen=True)
class Record:
    """What `load` has found to be sound; whether it is true, `verify` says."""

    folder: Path
    suite: str
    suite_hash: str
    split: str
    seed: int
    episodes: int
    official: bool
    reference: str
    families: tuple[str, ...]
    params: Params
    versions: dict[str, str]
    policies: tuple[Policy, ...]

    def __getitem__(self, name: str) -> Policy:
        """The policy of that name."""
        return next(policy for policy in self.policies if policy.name == name)


# Field -> test, and what would be right
Checks = Mapping[str, tuple[Callable[[Any], bool], str]]


def _whole(low: int, high: int) -> Callable[[Any], bool]:
    return lambda value: type(value) is int and low <= value <= high


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= SPEC_MAX and value.isprintable()


def _is_limit(value: Any) -> bool:
    return value is None or (type(value) in (int, float) and abs(value) < 1e300)


_HEX = (lambda value: isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value) is not None, "64 hex digits")
_NAME = (is_name, f"1 to {NAME_MAX} printable characters")
_TEXT = (_is_text, f"at most {SPEC_MAX} printable characters")
_LIMIT = (_is_limit, "a finite number or null")
_TABLE_FILE = re.compile(TABLES + r"/[0-9]{2,4}-[A-Za-z0-9.=_-]{0,80}\.npz")

_RECORD: Checks = {
    "schema": (lambda value: type(value) is int and value == SCHEMA, f"{SCHEMA}, which this version reads"),
    "suite": _NAME,
    "suite_hash": _HEX,
    "split": (lambda value: isinstance(value, str) and value in SPLITS, "one of " + ", ".join(SPLITS)),
    "seed": (_whole(0, SEED_LIMIT - 1), "a whole number in [0, 2**63)"),
    "episodes": (_whole(1, EPISODES_MAX), f"a whole number in [1, {EPISODES_MAX}]"),
    "official": (lambda value: isinstance(value, bool), "true or false"),
    "reference": _NAME,
    "families": (lambda value: isinstance(value, list), "a list of families"),
    "params": (lambda value: isinstance(value, dict), "a table of parameters"),
    "versions": (
        lambda value: (
            isinstance(value, dict)
            and len(value) <= 100
            and all(is_name(key) and is_name(text) for key, text in value.items())
        ),
        "a table of package names and versions",
    ),
    "policies": (
        lambda value: isinstance(value, list) and 1 <= len(value) <= POLICIES_MAX,
        f"a list of 1 to {POLICIES_MAX} policies",
    ),
}
_POLICY: Checks = {
    "name": _NAME,
    "spec": _TEXT,
    "hash": _HEX,
    "track": (lambda value: value in get_args(Track), "one of " + ", ".join(get_args(Track))),
    "metrics": (lambda value: isinstance(value, dict), "a table of metrics"),
    "table": (
        lambda value: isinstance(value, str) and _TABLE_FILE.fullmatch(value) is not None,
        f"a file such as {TABLES}/00-none.npz",
    ),
    "table_sha256": _HEX,
}
_ESTIMATE: Checks = {
    "value": _LIMIT,
    "low": _LIMIT,
    "high": _LIMIT,
    "n": (_whole(0, SEED_LIMIT - 1), "a whole number >= 0"),
    "unit": _TEXT,
}
# Columns of the table whose values have a lower end other than zero, or none.
_LOWEST = {"warned_s": -1.0, "approach_s": -np.inf, "sample_separation_m": -np.inf, "sample_range_m": -np.inf}
# Properties of the encounter, whoever flies.
_SHARED = ("family", "channel", "duration_s", "approach_s")


def load(folder: str | os.PathLike[str]) -> Record:
    """The record in a folder that `records.save` wrote, with its tables.

    Raises
    ------
    RecordError
        For anything else.
    """
    root = Path(folder)
    file = root / SCORES
    if not root.is_dir():
        raise RecordError(f"{str(folder)!r} is not a folder; a record is a folder with a {SCORES}")
    content = parse(_read(file, SCORES_BYTES_MAX), str(file))
    suite = content.get("suite") if isinstance(content, dict) else None
    if isinstance(suite, str) and suite in ROADS:
        raise RecordError(f"{file}: suite {suite!r} is of a road, whose records are neither flown again nor ranked")
    fields = _checked(str(file), "", content, _RECORD)
    params, families = _params(str(file), fields["params"])
    if fields["families"] != families:
        raise RecordError(
            f"{file}: families = {_shown(fields['families'])} must be {families}, those of params.encounter.families"
        )
    if (root / TABLES).is_symlink():
        raise RecordError(f"{root / TABLES} is a symbolic link; a record holds plain files and folders")
    size = fields["episodes"] * len(fields["policies"]) * TABLE.itemsize
    if size > TABLES_BYTES_MAX:
        raise RecordError(
            f"{file}: {len(fields['policies'])} policies of {fields['episodes']} episodes are {size} bytes of tables; "
            f"they must be at most {TABLES_BYTES_MAX}"
        )
    policies: list[Policy] = []
    for index, item in enumerate(fields["policies"]):
        where = f"policies[{index}]"
        values = _checked(str(file), where, item, _POLICY)
        metrics = _metrics(str(file), f"{where}.metrics", values["metrics"])
        for field, other in (("name", {p.name for p in policies}), ("table", {p.file for p in policies})):
            if values[field] in other:
                raise RecordError(f"{file}: {where}.{field} = {values[field]!r} is given twice; it must be unique")
        if values["name"] == NOMINAL != values["spec"]:
            raise RecordError(f"{file}: {where}.spec = {values['spec']!r} must be {NOMINAL!r} as the name is")
        table = read_table(root / values["table"], fields["episodes"])
        _check_rows(str(root / values["table"]), table, params, len(families))
        if table_digest(table) != values["table_sha256"]:
            raise RecordError(
                f"{file}: {where}.table_sha256 = {values['table_sha256']!r} must be {table_digest(table)!r}, the "
                f"digest of {values['table']}: table or record was changed"
            )
        names = {key: values[key] for key in ("name", "spec", "hash", "track", "table_sha256")}
        policies.append(Policy(**names, metrics=metrics, file=values["table"], table=table))
    record = Record(
        folder=root,
        params=params,
        families=tuple(families),
        policies=tuple(policies),
        **{
            key: fields[key]
            for key in ("suite", "suite_hash", "split", "seed", "episodes", "official", "reference", "versions")
        },
    )
    _check_policies(str(file), record)
    return record


def parse(data: bytes, file: str) -> Any:
    """JSON without NaN, infinities, duplicate keys or deep nesting.

    Raises
    ------
    RecordError
        For anything else; `file` is named in the sentence.
    """

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        table: dict[str, Any] = {}
        for key, value in items:
            if key in table:
                raise RecordError(f"{file}: field {_shown(key)} is given twice in one table; it must be given once")
            table[key] = value
        return table

    def number(text: str) -> float:
        value = float(text)
        if not math.isfinite(value):
            raise RecordError(f"{file}: number {text[:40]} must be finite")
        return value

    try:
        text = data.decode("utf-8")
        _check_depth(text, file)
        return json.loads(text, object_pairs_hook=pairs, parse_float=number, parse_constant=number)
    except RecordError:
        raise
    except ValueError as error:  # not UTF-8, not JSON, or a whole number of thousands of digits
        raise RecordError(f"{file} is not JSON: {error}") from error


def _check_depth(text: str, file: str) -> None:
    depth, quoted = 0, False
    for match in re.finditer(r'\\.|["\[\]{}]', text):
        token = match[0]
        if token == '"':
            quoted = not quoted
        elif not quoted and token in "[{":
            depth += 1
            if depth > DEPTH_MAX:
                raise RecordError(f"{file} nests tables and lists deeper than {DEPTH_MAX}; a record does not")
        elif not quoted and token in "]}":
            depth -= 1


def _read(file: Path, limit: int) -> bytes:
    with _opened(file, limit) as stream:
        return stream.read(limit)


def _opened(file: Path, limit: int) -> BinaryIO:
    """A plain file of at most `limit` bytes, opened."""
    try:
        info = file.lstat()
        if stat.S_ISLNK(info.st_mode):
            raise RecordError(f"{file} is a symbolic link; a record holds plain files and folders")
        if not stat.S_ISREG(info.st_mode):
            raise RecordError(f"{file} is not a plain file")
        if info.st_size > limit:
            raise RecordError(f"{file} has {info.st_size} bytes; it must have at most {limit}")
        return file.open("rb")
    except FileNotFoundError:
        raise RecordError(f"{file} is missing; a record holds {SCORES} and its tables") from None
    except OSError as error:
        raise RecordError(f"{file} cannot be read: {error}") from error


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80
_SHORT.maxlevel = 2


def _shown(value: Any) -> str:
    """A value from a file, short and printable."""
    return _SHORT.repr(value)


def _checked(file: str, where: str, value: Any, checks: Checks) -> dict[str, Any]:
    """The table itself, found to have the fields of `checks` and no others."""
    if not isinstance(value, dict):
        raise RecordError(f"{file}: {where or 'the whole'} = {_shown(value)} must be a table with {', '.join(checks)}")
    _refuse_unknown(file, where, value, checks)
    for name, (test, right) in checks.items():
        path = f"{where}.{name}" if where else name
        if name not in value:
            raise RecordError(f"{file}: {path} is missing; it must be {right}")
        if not test(value[name]):
            raise RecordError(f"{file}: {path} = {_shown(value[name])} must be {right}")
    return value


def _refuse_unknown(file: str, where: str, value: dict[str, Any], known: Iterable[str]) -> None:
    for name in value:
        if name not in known:
            path = f"{where}.{name}" if where else name
            raise RecordError(f"{file}: field {_shown(path)} is unknown{suggestion(name[:NAME_MAX], known)}")


def _metrics(file: str, where: str, value: dict[str, Any]) -> dict[str, Estimate]:
    _refuse_unknown(file, where, value, METRICS)
    metrics = {}
    for name, item in value.items():
        fields = _checked(file, f"{where}.{name}", item, _ESTIMATE)
        if fields["unit"] != METRICS[name].unit:
            raise RecordError(f"{file}: {where}.{name}.unit = {_shown(fields['unit'])} must be {METRICS[name].unit!r}")
        estimate = Estimate(**fields)
        if estimate.low is not None and estimate.high is not None and estimate.low > estimate.high:
            raise RecordError(f"{file}: {where}.{name}.low = {estimate.low} must not be above high = {estimate.high}")
        metrics[name] = estimate
    return metrics


def _params(file: str, value: dict[str, Any]) -> tuple[Params, list[str]]:
    channels = value.get("channels")
    # A channel may elsewhere be the name of a file; here that would open a file of the record's choice.
    if (
        not isinstance(channels, list)
        or not 1 <= len(channels) <= CHANNELS_MAX
        or not all(isinstance(channel, dict) for channel in channels)
    ):
        raise RecordError(f"{file}: params.channels = {_shown(channels)} must be a list of 1 to {CHANNELS_MAX} tables")
    try:
        params = Params.from_dict(value)
        families = chosen(params.encounter)
    except (ParamsError, TypeError, OverflowError) as error:
        raise RecordError(f"{file}: params: {error}") from error
    for group, whole in params.to_dict().items():
        if value.get(group) != whole:
            raise RecordError(f"{file}: params.{group} = {_shown(value.get(group))} must hold all of {_shown(whole)}")
    return params, families


def _check_policies(file: str, record: Record) -> None:
    names = [policy.name for policy in record.policies]
    for name in (NOMINAL, record.reference):
        if name not in names:
            raise RecordError(
                f"{file}: policies must include {name!r}, which others are compared with; they are {names}"
            )
    none = record[NOMINAL]
    for policy in record.policies:
        for column in _SHARED:
            wrong = np.flatnonzero(policy.table[column] != none.table[column])
            if len(wrong):
                raise RecordError(
                    f"{record.folder / policy.file}: column {column!r} of episode {wrong[0]} is "
                    f"{policy.table[column][wrong[0]]}, must be {none.table[column][wrong[0]]} as in {none.file}: the "
                    "encounters are the same for every policy"
                )


def read_table(file: Path, episodes: int) -> np.ndarray:
    """The table of so many episodes in a `.npz` file; memory is taken only for what these need.

    Raises
    ------
    RecordError
        If the file does not hold exactly the columns of `TABLE` in that length.
    """
    with _opened(file, episodes * TABLE.itemsize + _OVERHEAD_BYTES) as stream:
        try:
            _check_directory(stream, file)
            with zipfile.ZipFile(stream) as archive:
                members = {f"{name}.npy": name for name in TABLE.names or ()}
                found = [info.filename for info in archive.infolist()]
                if sorted(found) != sorted(members):
                    wrong = sorted(set(found) ^ set(members)) or found
                    raise RecordError(
                        f"{file}: members differ from the table's columns by {_shown(wrong)}; they must be one "
                        f".npy of each of {', '.join(members.values())}"
                    )
                table = np.zeros(episodes, TABLE)
                for info in archive.infolist():
                    column = members[info.filename]
                    table[column] = _column(archive, info, TABLE[column], episodes, f"{file}: column {column!r}")
                return table
        except RecordError:
            raise
        except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, RuntimeError, ValueError) as error:
            raise RecordError(f"{file} is not an intact .npz table: {error}") from error


def _check_directory(stream: BinaryIO, file: Path) -> None:
    """Refuse a zip directory other than the one of a table, before anything is made of its entries."""
    end = struct.Struct("<4s4H2LH")
    size = stream.seek(0, os.SEEK_END)
    if size < end.size:
        raise RecordError(f"{file} is not an intact .npz table: it has {size} bytes")
    tail = min(size, end.size + 20)  # with room for the locator of a larger directory
    stream.seek(size - tail)
    data = stream.read(tail)
    mark, disk, start_disk, here, total, length, offset, comment = end.unpack(data[-end.size :])
    if mark != b"PK\x05\x06":
        raise RecordError(f"{file} is not an intact .npz table: it does not end in a zip directory")
    expected = len(TABLE.names or ())
    plain = (disk, start_disk, comment) == (0, 0, 0) and b"PK\x06\x07" not in data
    if not plain or here != total or length > _OVERHEAD_BYTES or offset + length + end.size != size:
        raise RecordError(f"{file} is not an intact .npz table: its zip directory is not a table's")
    if total != expected:
        raise RecordError(f"{file} has {total} members; it must have one for each of the {expected} columns")
    stream.seek(0)


def _column(archive: zipfile.ZipFile, info: zipfile.ZipInfo, kind: np.dtype, n: int, where: str) -> np.ndarray:
    wanted = n * kind.itemsize
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
        raise RecordError(f"{where} is encrypted or compressed in an unusual way; it must be plain or deflated")
    if not wanted < info.file_size <= wanted + _HEADER_BYTES_MAX:
        raise RecordError(f"{where} has {info.file_size} bytes; {n} rows of {kind} have {wanted} and a short header")
    with archive.open(info) as stream:
        version = np.lib.format.read_magic(stream)
        if version != (1, 0):
            raise RecordError(f"{where} has array format {version}; it must be (1, 0)")
        try:
            shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream, max_header_size=_HEADER_BYTES_MAX)
        except Exception as error:  # it is read by Python's own tokeniser, which has errors of its own
            raise RecordError(f"{where} has no array header: {' '.join(str(error).split())}") from error
        if shape != (n,) or dtype != kind or dtype.hasobject or fortran:
            raise RecordError(f"{where} holds {dtype} of shape {shape}; it must be {kind} of shape ({n},)")
        data = stream.read(wanted)
        if len(data) != wanted or stream.read(1):
            raise RecordError(f"{where} does not hold {n} rows of {kind}")
    # A byte other than 0 and 1 is no truth value, though NumPy would take it for one.
    if kind == np.bool_ and any(byte > 1 for byte in set(data)):
        raise RecordError(f"{where} has a byte above 1; truth values are 0 or 1")
    return np.frombuffer(data, kind)


def _check_rows(file: str, table: np.ndarray, params: Params, families: int) -> None:
    """Values that no flight can have, and columns that contradict each other."""
    highest = {"family": families - 1, "channel": len(params.channels) - 1}

    def refuse(column: str, wrong: np.ndarray, right: str) -> None:
        rows = np.flatnonzero(wrong)
        if len(rows):
            raise RecordError(
                f"{file}: column {column!r} of row {rows[0]} is {table[column][rows[0]]}, must be {right}"
            )

    refuse("episode", table["episode"] != np.arange(len(table), dtype=np.uint64), "the row's number")
    for column in TABLE.names or ():
        values, low = table[column], _LOWEST.get(column, 0)
        if values.dtype.kind == "f":
            refuse(column, ~np.isfinite(values), "finite")
        if values.dtype.kind in "fi":
            refuse(column, values < low, f"at least {low}")
        if column in highest:
            refuse(column, values > highest[column], f"at most {highest[column]}")
    refuse("duration_s", table["duration_s"] <= 0.0, "above zero")
    refuse("flown_s", (table["flown_s"] <= 0.0) | (table["flown_s"] > table["duration_s"]), "in (0, duration_s]")
    for column, radius_m in (("collision", params.zone.collision_m), ("zone", params.zone.radius_m)):
        gap_m = table["min_separation_m"] - radius_m
        wrong = np.where(table[column], gap_m > _TIE_M, gap_m < -_TIE_M)
        refuse(column, wrong, f"what min_separation_m and the limit of {radius_m:g} m say")
