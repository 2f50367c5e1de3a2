"""The learned drivers of roads beside the rule, and what they are without the radio: paired drives of split `suite`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines import make
from rss_gym.baselines.policy_files import document_of, read
from rss_gym.eval.columns import ROAD
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.intervals import Interval, clopper_pearson, mean_t, paired_difference
from rss_gym.eval.policies import folder_name
from rss_gym.eval.studies.section import Criterion, Section
from rss_gym.eval.suites import Suite, find
from rss_gym.ids import ROADS
from rss_gym.pages.table import Column
from rss_gym.params import ParamsError, Reward

RULE, SPLIT, SEED = "rule", "suite", 0
COLLISIONS, DEVIATION = ROAD["collision_rate"], ROAD["path_deviation_mean_m"]
GAPS = (
    Column("collisions minus rule's", form="+.3f", interval=True),
    Column("deviation minus rule's, m", form="+.1f", interval=True),
)


@dataclass(frozen=True)
class Driver:
    """A learned driver from its folder: the road and the prices of its training, and whether it hears the others."""

    name: str
    folder: str
    road: str
    is_blind: bool
    prices: Reward = field(default_factory=Reward)


def driver(folder: str) -> Driver:
    """What the folder of a learned driver says of it.

    Raises
    ------
    ParamsError
        If it records no training on a road.
    """
    recipe = document_of(read(Path(folder))[0]).get("training", {}).get("recipe", {})
    road = recipe.get("recipe", {}).get("env")
    if road not in ROADS:
        raise ParamsError(f"--learned {folder!r}: the folder must hold a driver trained on {', '.join(ROADS)}")
    blind = recipe.get("policy", {}).get("zeroed") == "radio"
    prices = Reward(**recipe.get("world", {}).get("reward", {}))
    return Driver(folder_name(folder) + (" without the radio" if blind else ""), folder, road, blind, prices)


def suite_of(road: str) -> Suite:
    """The suite of a road's id."""
    return find(f"{ROADS[road]['scene']}-v0")


def section(road: str, drivers: Sequence[Driver], episodes: int) -> Section:
    """Rule and drivers on the same drives, and whether they beat it in collisions and deviation at once."""
    suite = suite_of(road)
    policies: dict[str, Any] = {RULE: make(RULE, suite.params)}
    policies |= {driver.name: make(driver.folder, suite.params) for driver in drivers}
    block = Block(SPLIT, SEED, range(episodes))
    tables = {name: fly_all(policy, name, suite.params, block, True) for name, policy in policies.items()}
    rows = [row(name, table, tables[RULE]) for name, table in tables.items()]
    return Section(
        f"Learned drivers on {suite.name}",
        f"{episodes:,} drives of split `{SPLIT}`, seed {SEED}, the same for each, in the traffic of trainings, which "
        "equals highway-env's but for rounding; differences are paired.",
        ["driver", "drives", COLLISIONS, DEVIATION, *GAPS],
        rows,
        criteria(drivers, tables),
    )


def row(name: str, table: np.ndarray, rule: np.ndarray) -> list[Any]:
    """A driver's rates and means, and its paired differences from the rule."""
    collisions = clopper_pearson(int(table["collision"].sum()), len(table))
    gaps = ["", ""] if table is rule else [collision_gap(table, rule), deviation_gap(table, rule)]
    return [f"`{name}`", str(len(table)), collisions, mean_t(table["deviation_mean_m"]), *gaps]


def collision_gap(table: np.ndarray, other: np.ndarray) -> Interval:
    """Difference of two drivers' collision rates on the same drives."""
    one, two = table["collision"].astype(bool), other["collision"].astype(bool)
    both, only_one, only_two = (int(np.count_nonzero(pair)) for pair in (one & two, one & ~two, two & ~one))
    return paired_difference(both, only_one, only_two, len(table))


def deviation_gap(table: np.ndarray, other: np.ndarray) -> Interval:
    """Mean difference (m) of two drivers' deviations on the same drives."""
    return mean_t(table["deviation_mean_m"] - other["deviation_mean_m"])


def cost_gap(table: np.ndarray, other: np.ndarray, prices: Reward) -> Interval:
    """Mean difference of two drivers' costs at the prices of a training, in metres of deviation."""

    def cost_m(of: np.ndarray) -> np.ndarray:
        events = prices.snmac_price_m * of["snmac"] + prices.collision_price_m * of["collision"]
        return np.asarray(of["deviation_mean_m"] + events / prices.deviation_price)

    return mean_t(cost_m(table) - cost_m(other))


def criteria(drivers: Sequence[Driver], tables: dict[str, np.ndarray]) -> list[Criterion]:
    """Each driver that hears against the rule, and against the one that does not."""
    found = []
    for seeing in (driver for driver in drivers if not driver.is_blind):
        gaps = collision_gap(tables[seeing.name], tables[RULE]), deviation_gap(tables[seeing.name], tables[RULE])
        found.append(
            Criterion(
                f"`{seeing.name}` collides less than the rule and stays nearer to the plan, beyond both intervals",
                ", ".join(shown(gap, column) for gap, column in zip(gaps, GAPS, strict=True)),
                all(gap.high is not None and gap.high < 0.0 for gap in gaps),
            )
        )
        for blind in (driver for driver in drivers if driver.is_blind):
            gap = cost_gap(tables[blind.name], tables[seeing.name], seeing.prices)
            found.append(
                Criterion(
                    f"`{blind.name}` costs more than `{seeing.name}` at the prices of its training, clearly",
                    f"{GAPS[1].cell(gap).plain} m more",
                    gap.low is not None and gap.low > 0.0,
                )
            )
    return found


def shown(gap: Interval, column: Column) -> str:
    """A difference with its interval and what it is of."""
    return f"{column.heading} {column.cell(gap).plain}"
