"""The report of an evaluation: one page that needs no network, `report.html`, and the flights that it replays.

The page is a function of a saved record: `rss_gym.eval.redraw` makes it again of `scores.json`, the tables and
`flights.json`, without a flight.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from rss_gym.eval.evaluate import Result
from rss_gym.eval.records import versions
from rss_gym.eval.report import charts, facts, families, replay, sensor, tables
from rss_gym.eval.report.flights import FLIGHTS, Flown
from rss_gym.files import write_text
from rss_gym.pages import page
from rss_gym.pages.page import CANVAS, SORTING, Section

__all__ = ["REPORT", "markup", "write"]

REPORT = "report.html"
SCRIPTS = (SORTING, CANVAS, Path(__file__).with_name("replay.js"))


def markup(
    result: Result, flown: Flown | None, packages: Mapping[str, str] | None = None, more: Sequence[Section] = ()
) -> str:
    """The page as text; the same arguments give the same text.

    Parameters
    ----------
    result : Result
        Of `rss_gym.eval.evaluate`, or read back from a record.
    flown : Flown, optional
        The flights to replay; without them the page says that there are none.
    packages : mapping, optional
        Version of each package that the numbers depend on; default: those of this process.
    more : sequence of Section, optional
        Put after the scores; their titles must differ from the page's own.
    """
    data = None if flown is None else replay.player(result, flown)
    packages = versions(*result.suite.domain.packages) if packages is None else packages
    sections = [
        Section("Safety against deviation", charts.safety(result)),
        Section("Scores", tables.main(result)),
        *more,
        Section("Replays", replay.markup(data), data),
        Section("Encounter families", families.breakdown(result)),
        Section("Sensor", sensor.section(result)),
        Section("All metrics", tables.everything(result)),
        Section("Run", facts.run(result, packages)),
    ]
    return page.render(f"Evaluation on {result.suite.name}", facts.lead(result), sections, SCRIPTS)


def write(result: Result, folder: str | os.PathLike[str], more: Sequence[Section] = ()) -> Path:
    """Write `report.html`, and `flights.json` with what it replays.

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
        The path of the page.
    """
    flown = replay.fly(result)
    write_text(Path(folder) / FLIGHTS, json.dumps(flown.document(), separators=(",", ":")) + "\n")
    return write_text(Path(folder) / REPORT, markup(result, flown, more=more))
