"""The page of `rss-gym calibrate --inspect --report DIR`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup

from rss_gym.calibration.logs import LogRecord
from rss_gym.calibration.logs.record import USED, LogFile
from rss_gym.eval.studies.calibration.inspect import facts
from rss_gym.eval.studies.calibration.output import PAGE
from rss_gym.eval.studies.calibration.text import printable
from rss_gym.files import new_folder
from rss_gym.pages import page
from rss_gym.pages.figure import COLOURS, MUTED, figure
from rss_gym.pages.markup import renderer
from rss_gym.pages.page import Section

render = renderer(__file__)
_POINTS = 1500  # drawn of a link


def write(logs: Sequence[tuple[LogFile, Sequence[LogRecord], Sequence[str]]], out: str | os.PathLike[str]) -> Path:
    """Write the page into a new folder and return its path."""
    sections = [Section(printable(file.source), _log(file, notes)) for file, _, notes in logs]
    rows = sum(rows.reason.size for file, _, _ in logs for rows in file.rows)
    lead = render("logs.html", logs=len(logs), rows=rows)
    with new_folder(out) as folder:
        (folder / PAGE).write_text(page.render("What the logs hold", lead, sections), encoding="utf-8")
    return Path(out) / PAGE


def _log(file: LogFile, notes: Sequence[str]) -> Markup:
    taken = {key or "not used": printable(name) for key, name in file.columns.items()}
    links = [(rows.link, facts(rows)) for rows in file.rows]
    return render("log.html", file=file, taken=taken, figure=_figure(file), links=links, notes=notes)


def _figure(file: LogFile) -> Markup:
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
    return drawing.html
