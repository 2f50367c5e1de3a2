"""Policies that do not listen, swept over a suite: none of them may be cheap where the radio is to decide.

Constant displacements of the way point, constant changes of the velocity, stopping, running back and, in space,
climbing and descending. They read of the observation only what the own plan says, the commanded way point and the
cruise speed. What is measured changes nothing for them, so the sweep leaves most of the radio out, which is quicker.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym import observation
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.episodes import Block, fly_all
from rss_gym.eval.intervals import Interval, clopper_pearson
from rss_gym.eval.suites import Suite, find
from rss_gym.params import Params

SIZES_M = (5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 1000.0)
HEIGHTS_M = (5.0, 10.0, 20.0, 60.0)
SHARES = (0.2, 0.5, 1.0)  # of the speed limit
DIRECTIONS = 16
AXES = ("along", "right", "up")
# Who does not listen flies alike with these. Nobody hears anything, and no node is ranged.
DEAF: dict[str, Any] = {
    "agent": "gnss",
    "intruder": "gnss",
    "estimator": "ls",
    "tracker": "latest",
    "channel": {"sensitivity_dbm": 0.0},
}


@dataclass(frozen=True)
class Displaced:
    """Brings the way point to a constant displacement from the predefined trajectory, as fast as it may, and stays."""

    name: str
    target_m: tuple[float, float, float]  # along, right, up

    def change_mps(self, here_m: np.ndarray, cruise_mps: np.ndarray, decision_s: float) -> np.ndarray:
        """Change of the way point's velocity, shape (n, 3), wanted at the displacement `here_m` (n, 3)."""
        return (np.asarray(self.target_m) - here_m) / decision_s


@dataclass(frozen=True)
class Drifting:
    """Changes the way point's velocity by a constant for the whole flight, and by a share of the planned one."""

    name: str
    constant_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    planned: float = 0.0  # -1 stops

    def change_mps(self, here_m: np.ndarray, cruise_mps: np.ndarray, decision_s: float) -> np.ndarray:
        """Change of the way point's velocity, shape (n, 3)."""
        out = np.tile(np.asarray(self.constant_mps), (len(here_m), 1))
        out[:, 0] += self.planned * cruise_mps
        return out


Manoeuvre = Displaced | Drifting


class Blind:
    """A manoeuvre as a policy of a world.

    Parameters
    ----------
    manoeuvre : Manoeuvre
    params : Params
    """

    def __init__(self, manoeuvre: Manoeuvre, params: Params) -> None:
        self.manoeuvre, self.params = manoeuvre, params
        table = {field.name: (column, field) for column, field in enumerate(observation.fields(params))}
        self.axes = AXES[: 2 if params.encounter.planar else 3]
        own = [table[name] for name in (*(f"way_point_{axis}_m" for axis in self.axes), "cruise_mps")]
        self.columns, self.fields = [column for column, _ in own], [field for _, field in own]

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, None]:
        """SB3's `predict`, for a batch."""
        values = np.asarray(observation_, dtype=np.float64)[:, self.columns]
        seen, axes = observation.restored(values, self.fields), len(self.axes)
        here_m = np.zeros((len(values), 3))
        here_m[:, :axes] = seen[:, :axes]
        aircraft, decision_s, cruise_mps = self.params.aircraft, self.params.clock.decision_s, seen[:, axes]
        limits = np.array([aircraft.speed_max_mps, aircraft.speed_max_mps, aircraft.vertical_speed_max_mps])
        actions = self.manoeuvre.change_mps(here_m, cruise_mps, decision_s) / limits
        # What is far is approached in its direction.
        actions[:, :2] /= np.maximum(1.0, np.abs(actions[:, :2]).max(axis=1, keepdims=True))
        return np.clip(actions[:, :axes], -1.0, 1.0).astype(np.float32), None


@dataclass(frozen=True)
class Swept:
    """What one manoeuvre came to.

    Attributes
    ----------
    name : str
    cost_m : Interval
    collision_rate : Interval
    deviation_m : float
    """

    name: str
    cost_m: Interval
    collision_rate: Interval
    deviation_m: float


def manoeuvres(params: Params) -> Iterator[Manoeuvre]:
    """Everything that the sweep tries in a world."""
    speed, climb = params.aircraft.speed_max_mps, params.aircraft.vertical_speed_max_mps
    for number in range(DIRECTIONS):
        angle = 2.0 * math.pi * number / DIRECTIONS
        along, right, degrees = math.cos(angle), math.sin(angle), 360.0 * number / DIRECTIONS
        for size in SIZES_M:
            yield Displaced(f"{size:g} m at {degrees:g} degrees", (size * along, size * right, 0.0))
        for share in SHARES:
            change = share * speed
            yield Drifting(f"{change:g} m/s at {degrees:g} degrees", (change * along, change * right, 0.0))
    yield Drifting("stopping", planned=-1.0)
    yield Drifting("running back", (-speed, 0.0, 0.0), planned=-1.0)
    if params.encounter.planar:
        return
    for sign, name in ((1.0, "up"), (-1.0, "down")):
        for height in HEIGHTS_M:
            yield Displaced(f"{height:g} m {name}", (0.0, 0.0, sign * height))
            for along, right, where in ((-30.0, 0.0, "back"), (0.0, 30.0, "right"), (0.0, -30.0, "left")):
                yield Displaced(f"{height:g} m {name}, 30 m {where}", (along, right, sign * height))
        for share in SHARES:
            yield Drifting(f"{share * climb:g} m/s {name}", (0.0, 0.0, sign * share * climb))


def deafened(params: Params) -> Params:
    """The world in which whoever does not listen flies the same encounters in the same way, only more quickly.

    On information `ranges` the intruder hovers when it is warned, so there the radio stays.
    """
    return params if params.interface.information == "ranges" else Params.of(params, **DEAF)


def sweep(suite: str | Suite, episodes: int = 2000, seed: int = 0, first: int = 200, kept: int = 16) -> list[Swept]:
    """Fly every manoeuvre over a suite's encounters, the cheapest first.

    All fly the first few encounters; those that may still be the cheapest, by the low ends of their costs' intervals,
    fly all of them.

    Parameters
    ----------
    suite : str or Suite
    episodes : int
        Encounters of those that are kept.
    seed : int
        Another than the suite's own gives other encounters.
    first, kept : int
        How many encounters all fly, and how many manoeuvres fly on.
    """
    flown = find(suite) if isinstance(suite, str) else suite
    params = deafened(flown.params)
    tried = list(manoeuvres(params))
    if episodes > first and len(tried) > kept:
        low = {one.name: _flown(one, params, flown.split, first, seed).cost_m.low or 0.0 for one in tried}
        tried = sorted(tried, key=lambda one: (low[one.name], one.name))[:kept]
    found = [_flown(one, params, flown.split, episodes, seed) for one in tried]
    return sorted(found, key=lambda swept: (swept.cost_m.value or 0.0, swept.name))


def cheapest(suite: str | Suite, episodes: int = 2000, seed: int = 0, first: int = 200, kept: int = 16) -> Swept:
    """The cheapest of `sweep`."""
    return sweep(suite, episodes, seed, first, kept)[0]


def _flown(manoeuvre: Manoeuvre, params: Params, split: str, episodes: int, seed: int) -> Swept:
    table = fly_all(Blind(manoeuvre, params), manoeuvre.name, params, Block(split, seed, range(episodes)))
    rate = clopper_pearson(int(np.count_nonzero(table["collision"])), episodes)
    costs = Costs.of(table, Prices.of(params))
    return Swept(manoeuvre.name, costs.interval(), rate, float(np.mean(table["deviation_mean_m"])))
