"""What a run on a road leaves: the record of the world, the deviations, and a page without replays."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.eval import records
from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import METRICS
from rss_gym.eval.report import REPORT, charts, facts, sensor, tables
from rss_gym.eval.road.evaluate import NAMES, RoadResult
from rss_gym.files import write_text
from rss_gym.pages import page
from rss_gym.pages.page import SORTING, Section

COLUMNS = {
    "collision_rate": ("collision rate", 1.0, ".3f"),
    "risk_ratio": ("risk ratio", 1.0, ".3f"),
    "zone_violation_rate": ("zone rate", 1.0, ".3f"),
    "lane_deviation_m": ("lane deviation m", 1.0, ".2f"),
    "speed_deviation_mps": ("speed deviation m/s", 1.0, ".2f"),
}
DEVIATIONS = "deviations.npz"  # name of a column -> (policies, episodes)


def save(result: RoadResult, out: str | os.PathLike[str], with_csv: bool = False) -> Path:
    """Write `scores.json`, the tables, the deviations and the page into the new folder `out`."""
    return records.save(result, out, with_csv, _rest)


def _rest(result: Result, folder: Path) -> None:
    assert isinstance(result, RoadResult)
    columns: dict[str, Any] = {
        name: np.array([rows[name] for rows in result.deviations])
        for name in ("lane_deviation_m", "speed_deviation_mps")
    }
    np.savez_compressed(folder / DEVIATIONS, **columns)
    write_text(folder / REPORT, markup(result))


def markup(result: RoadResult) -> str:
    """The page as text."""
    main = [
        "collision_rate",
        "risk_ratio",
        "zone_violation_rate",
        "path_deviation_mean_m",
        "unnecessary_manoeuvre_rate",
    ]
    rest = [name for name in NAMES if not METRICS[name].sensor]
    sections = [
        Section("Safety against deviation", charts.safety(result) + charts.CAPTION),
        Section("Scores", tables.table(result, main) + NOTE),
        Section("Sensor", sensor.section(result)),
        Section("All metrics", tables.table(result, rest)),
        Section("Run", facts.run(result)),
    ]
    return page.render(f"Evaluation on {result.suite.name}", facts.lead(result), sections, (SORTING,))


NOTE = (
    '<p class="note">The zone of a pair is (40) at the true closing speed; it is violated by a vehicle on the agent\'s '
    "own lane only. The deviation is the distance from where the planned lane and speed would have led; the means of "
    "both parts are in scores.json.</p>"
)
