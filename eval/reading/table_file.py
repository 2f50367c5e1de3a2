"""The table of a policy: read only after its zip directory and array headers have been found to be a table's."""

from __future__ import annotations

import os
import struct
import zipfile
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from rss_gym.domain import AIR, domain_of
from rss_gym.eval.costs import Prices, cost_m
from rss_gym.eval.reading.plain import RecordError, opened, shown
from rss_gym.eval.table import TABLE
from rss_gym.params import Params

TABLE_BYTES_MAX = 2**30
EPISODES_MAX = TABLE_BYTES_MAX // TABLE.itemsize

# What zip and array headers may add to a table's rows, with room to spare.
_OVERHEAD_BYTES = 2**16
_HEADER_BYTES_MAX = 1024
_TIE_M = 1e-9  # two ways of rounding a separation
# Columns of the table whose values have a lower end other than zero, or none.
_LOWEST = {"warned_s": -1.0, "approach_s": -np.inf, "sample_separation_m": -np.inf, "sample_range_m": -np.inf}


def read_table(file: Path, episodes: int, columns: np.dtype = TABLE) -> np.ndarray:
    """The table of so many episodes in a `.npz` file; memory is taken only for what these need.

    Raises
    ------
    RecordError
        If the file does not hold exactly these columns in that length.
    """
    with opened(file, episodes * columns.itemsize + _OVERHEAD_BYTES) as stream:
        try:
            _check_directory(stream, file, len(columns.names or ()))
            with zipfile.ZipFile(stream) as archive:
                members = {f"{name}.npy": name for name in columns.names or ()}
                found = [info.filename for info in archive.infolist()]
                if sorted(found) != sorted(members):
                    wrong = sorted(set(found) ^ set(members)) or found
                    raise RecordError(
                        f"{file}: members differ from the table's columns by {shown(wrong)}; they must be one "
                        f".npy of each of {', '.join(members.values())}"
                    )
                table = np.zeros(episodes, columns)
                for info in archive.infolist():
                    column = members[info.filename]
                    table[column] = _column(archive, info, columns[column], episodes, f"{file}: column {column!r}")
                return table
        except RecordError:
            raise
        except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, RuntimeError, ValueError) as error:
            raise RecordError(f"{file} is not an intact .npz table: {error}") from error


def _check_directory(stream: BinaryIO, file: Path, expected: int) -> None:
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


def check_rows(file: str, table: np.ndarray, params: Params, families: int, first_episode: int = 0) -> None:
    """Values that no flight can have, and columns that contradict each other."""
    highest = {"family": families - 1, "channel": len(params.channels) - 1}

    def refuse(column: str, wrong: np.ndarray, right: str) -> None:
        rows = np.flatnonzero(wrong)
        if len(rows):
            raise RecordError(
                f"{file}: column {column!r} of row {rows[0]} is {table[column][rows[0]]}, must be {right}"
            )

    numbers = np.arange(len(table), dtype=np.uint64) + np.uint64(first_episode)
    refuse("episode", table["episode"] != numbers, "the row's number, from first_episode on")
    for column in table.dtype.names or ():
        values, low = table[column], _LOWEST.get(column, 0)
        if values.dtype.kind == "f":
            refuse(column, ~np.isfinite(values), "finite")
        if values.dtype.kind in "fi":
            refuse(column, values < low, f"at least {low}")
        if column in highest:
            refuse(column, values > highest[column], f"at most {highest[column]}")
    refuse("duration_s", table["duration_s"] <= 0.0, "above zero")
    refuse("flown_s", (table["flown_s"] <= 0.0) | (table["flown_s"] > table["duration_s"]), "in (0, duration_s]")
    radii_m = {"collision": params.zone.collision_m, "zone": params.zone.radius_m}
    for column, radius_m in radii_m.items() if domain_of(params) is AIR else ():  # a road has shapes and lanes
        gap_m = table["min_separation_m"] - radius_m
        wrong = np.where(table[column], gap_m > _TIE_M, gap_m < -_TIE_M)
        refuse(column, wrong, f"what min_separation_m and the limit of {radius_m:g} m say")
    refuse("zone_severity", table["zone_severity"] > 1.0, "at most 1")
    costs = cost_m(table["deviation_mean_m"], table["snmac"], table["collision"], Prices.of(params))
    wrong = ~np.isclose(table["cost_m"], costs, rtol=_TIE_M, atol=_TIE_M)
    refuse("cost_m", wrong, "the cost of deviation_mean_m, snmac and collision by the record's prices")
