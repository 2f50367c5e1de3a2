"""What a log holds, before anything is fitted: `rss-gym calibrate --inspect`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rss_gym.calibration.logs import LogRecord, ReadOptions, read_file, sources
from rss_gym.calibration.logs.clean import cleaned
from rss_gym.calibration.logs.record import REASONS, USED, LogFile, Rows
from rss_gym.checks import Floats
from rss_gym.eval.studies.calibration.text import printable
from rss_gym.pages.table import Table
from rss_gym.params import ParamsError

PLOT_COLUMNS, PLOT_ROWS = 64, 16
_DENSITY = " .:*#"


def inspect(
    names: Sequence[str],
    format: str | None,
    reading: Mapping[str, Any],
    report: str | os.PathLike[str] | None = None,
) -> None:
    """Print what every log holds: format, links, rates, spans, dropped rows, a plot; with `report` write a page too.

    A log that would be refused is described too, with the reason.

    Raises
    ------
    ParamsError
        If a file is no log of any known format.
    """
    options = ReadOptions(**reading)
    if report is not None:
        from rss_gym.files import check_new

        check_new(report)
    everything = []
    for name, source in zip(names, sources(list(names)), strict=True):
        file = read_file(name, format, options, source)
        try:
            records, notes = cleaned(file, options)
        except ParamsError as error:
            records, notes = [], [f"refused: {error}"]
        print(description(file, records, notes))
        everything.append((file, records, notes))
    if report is not None:
        from rss_gym.eval.studies.calibration.inspect_page import write

        print(f"report: {write(everything, report)}")


def description(file: LogFile, records: Sequence[LogRecord], notes: Sequence[str]) -> str:
    """One log in lines of text."""
    lines = [f"{file.source}: {file.format}, {sum(rows.reason.size for rows in file.rows):,} rows"]
    lines += _listed([(key or "not used", printable(column)[:200]) for key, column in file.columns.items()], "  ")
    for rows in file.rows:
        lines += [f"  link {rows.link!r}" + (f", sender {rows.sender}" if rows.sender else "")]
        lines += _listed(list(facts(rows).items()), "    ")
    lines += [f"  note: {note}" for note in notes]
    shown = [record for record in records if record.time_s.size]
    if shown:
        lines += ["", *plot(shown), ""]
    return "\n".join(lines)


def _listed(items: list[tuple[str, str]], indent: str) -> list[str]:
    return [indent + line for line in Table(("name", "value"), items).lines(header=False)]


def facts(rows: Rows) -> dict[str, str]:
    """What a link's rows hold, by name."""
    used = rows.reason == USED
    found = {"rows": f"{used.sum():,} used of {used.size:,}"}
    if used.sum() > 1:
        time_s = rows.time_s[used]
        steps = np.diff(time_s)
        found["time"] = (
            f"{time_s[-1] - time_s[0]:.1f} s, every {np.median(steps):.3g} s, longest gap {steps.max():.3g} s"
        )
        found["RSS"] = _span(rows.rss_dbm[used], "dBm")
        found["distance"] = _span(rows.distance_m[used], "m")
        rate = rows.range_rate_mps
        found["rate"] = "no velocity" if rate is None else _span(rate[used], "m/s")
    codes, times = np.unique(rows.reason[~used], return_counts=True)
    dropped = [f"{count:,} {REASONS[code]}" for code, count in zip(codes.tolist(), times.tolist(), strict=True)]
    return found | ({"dropped": "; ".join(dropped)} if dropped else {})


def _span(values: Floats, unit: str) -> str:
    values = values[np.isfinite(values)]
    if not values.size:
        return "not known"
    return f"{values.min():.1f} to {values.max():.1f} {unit}, median {np.median(values):.1f}"


def plot(records: Sequence[LogRecord]) -> list[str]:
    """RSS over the logarithm of the distance, all links, as characters."""
    x = np.log10(np.concatenate([record.distance_m for record in records]))
    y = np.concatenate([record.rss_dbm for record in records])
    if np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return []
    counts, _, _ = np.histogram2d(y, x, bins=(PLOT_ROWS, PLOT_COLUMNS))
    top = max(float(np.quantile(counts[counts > 0], 0.95)), 1.0)
    marks = np.where(counts > 0, np.clip(np.ceil(4.0 * counts / top), 1, 4), 0).astype(int)
    lines = [
        f"  RSS, dBm ({y.min():.0f} to {y.max():.0f}) over distance, m ({10 ** x.min():.3g} to {10 ** x.max():.3g})"
    ]
    for k in range(PLOT_ROWS - 1, -1, -1):
        level = y.min() + (k + 0.5) * np.ptp(y) / PLOT_ROWS
        lines.append(f"  {level:7.1f} |{''.join(_DENSITY[mark] for mark in marks[k]).rstrip()}")
    lines.append("          +" + "-" * PLOT_COLUMNS)
    return lines
