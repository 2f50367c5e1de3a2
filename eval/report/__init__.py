"""The report of an evaluation: one page that needs no network, `report.html`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from rss_gym.eval.evaluate import Result
from rss_gym.eval.report import charts, facts, families, replay, sensor, tables
from rss_gym.files import write_text
from rss_gym.pages import page
from rss_gym.pages.page import SORTING, Section

__all__ = ["REPORT", "markup", "write"]

REPORT = "report.html"
SCRIPTS = (SORTING, Path(__file__).with_name("replay.js"))


def markup(result: Result, more: Sequence[Section] = ()) -> str:
    """The page as text, with `more` after the scores; the same result gives the same text."""
    flights = replay.collect(result)
    sections = [
        Section("Safety against deviation", charts.safety(result) + charts.CAPTION),
        Section("Scores", tables.main(result)),
        *more,
        Section("Replays", replay.markup(result, flights), flights),
        Section("Encounter families", families.breakdown(result)),
        Section("Sensor", sensor.section(result)),
        Section("All metrics", tables.everything(result)),
        Section("Run", facts.run(result)),
    ]
    return page.render(f"Evaluation on {result.suite.name}", facts.lead(result), sections, SCRIPTS)


def write(result: Result, folder: str | os.PathLike[str], more: Sequence[Section] = ()) -> Path:
    """Write `report.html`.

    Parameters
    ----------
    result : Result
        Of `rss_gym.eval.evaluate`. A few of its encounters are flown again.
    folder : path
        Must exist; an older report in it is replaced.
    more : sequence of Section, optional
        Put after the scores; their titles must differ from the page's own.

    Returns
    -------
    Path
        Of the file.
    """
    return write_text(Path(folder) / REPORT, markup(result, more))
