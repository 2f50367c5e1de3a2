"""The page of `rss-gym calibrate --inspect --report DIR`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rss_gym.calibration.logs import LogRecord
from rss_gym.calibration.logs.record import USED, LogFile
from rss_gym.eval.studies.calibration.inspect import facts
from rss_gym.eval.studies.calibration.output import PAGE
from rss_gym.eval.studies.calibration.text import printable
from rss_gym.files import new_folder
from rss_gym.pages.figure import COLOURS, MUTED, figure
from rss_gym.pages.page import Section, render, text

_POINTS = 1500  # drawn of a link


def write(logs: Sequence[tuple[LogFile, Sequence[LogRecord], Sequence[str]]], out: str | os.PathLike[str]) -> Path:
    """Write the page into a new folder and return its path."""
    sections = [Section(printable(file.source), _log(file, notes)) for file, _, notes in logs]
    rows = sum(rows.reason.size for file, _, _ in logs for rows in file.rows)
    lead = f'<p class="lead">{len(logs)} log{"s" if len(logs) > 1 else ""}, {rows:,} rows.</p>'
    with new_folder(out) as folder:
        (folder / PAGE).write_text(render("What the logs hold", lead, sections), encoding="utf-8")
    return Path(out) / PAGE


def _log(file: LogFile, notes: Sequence[str]) -> str:
    links = "".join(
        f"<h3>{text(rows.link)}</h3><dl>"
        + "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>" for name, value in facts(rows).items())
        + "</dl>"
        for rows in file.rows
    )
    taken = "".join(
        f"<dt>{text(key or 'not used')}</dt><dd>{text(printable(name))}</dd>" for key, name in file.columns.items()
    )
    listed = "".join(f"<li>{text(note)}</li>" for note in notes)
    return (
        f'<p class="text">{text(file.format)}.</p><dl>{taken}</dl>'
        + _figure(file)
        + links
        + (f"<ul>{listed}</ul>" if listed else "")
    )


def _figure(file: LogFile) -> str:
    """RSS over time and over distance; dropped rows in grey."""
    with figure("RSS over time and over distance", 1, 2, width_in=11.0, height_in=3.2, sharey=True) as drawing:
        left, right = drawing.axes
        start_s = min((float(np.nanmin(r.time_s)) for r in file.rows if np.isfinite(r.time_s).any()), default=0.0)
        for k, rows in enumerate(file.rows[: len(COLOURS)]):
            shown = slice(None, None, max(1, rows.reason.size // _POINTS))
            used = rows.reason[shown] == USED
            for axes, x in ((left, rows.time_s[shown] - start_s), (right, rows.distance_m[shown])):
                axes.plot(x[~used], rows.rss_dbm[shown][~used], ".", color=MUTED, markersize=2.0, alpha=0.4)
                label = printable(rows.link)[:20].replace("$", r"\$")
                axes.plot(x[used], rows.rss_dbm[shown][used], ".", color=COLOURS[k], markersize=2.5, label=label)
        left.set(xlabel="time, s", ylabel="RSS, dBm")
        right.set(xlabel="distance, m", xscale="log")
        right.legend(loc="upper right", markerscale=4.0)
    return drawing.markup
