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
from rss_gym.eval.text import Columns
from rss_gym.files import write_text
from rss_gym.pages import page
from rss_gym.pages.page import SORTING, Section

COLUMNS: Columns = {
    "cost_m": ("cost m", 1.0, ".1f"),
    "collision_rate": ("collision rate", 1.0, ".3f"),
    "snmac_rate": ("near misses", 1.0, ".3f"),
    "path_deviation_mean_m": ("deviation m", 1.0, ".1f"),
    "lane_deviation_m": ("off the lane m", 1.0, ".2f", False),
    "speed_deviation_mps": ("off the speed m/s", 1.0, ".2f", False),
}
MAIN = (
    "cost_m",
    "collision_rate",
    "snmac_rate",
    "path_deviation_mean_m",
    "unnecessary_manoeuvre_rate",
    "zone_violation_rate",
    "path_regained_rate",
)
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
    rest = [name for name in NAMES if not METRICS[name].sensor]
    sections = [
        Section("Safety against deviation", charts.safety(result) + charts.CAPTION),
        Section("Scores", tables.table(result, list(MAIN), places=True) + NOTE),
        Section("Sensor", sensor.section(result)),
        Section("All metrics", tables.table(result, rest)),
        Section("Run", facts.run(result)),
    ]
    return page.render(f"Evaluation on {result.suite.name}", facts.lead(result), sections, (SORTING,))


NOTE = (
    '<p class="note">Ranked by cost: mean deviation while driven, plus 100 m for a near miss and 10,000 m for a '
    "collision; a difference from the first is of the pairs of drives. The deviation is the distance from where the "
    "planned lane and speed would have led; the means of both parts are in scores.json. A near miss, called sNMAC "
    "as in the air: at a tick a vehicle would touch the agent within 1.5 s if both went straight on. The zone of a "
    "pair is (40) at the true closing speed; it is violated by a vehicle on the agent's own lane only.</p>"
)
