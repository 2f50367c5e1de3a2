"""The parameters of a road: the world's, with the group `road`, and set by the names that a road knows."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

from rss_gym.highway.scene import SCENES, scene_class
from rss_gym.params import (
    MAX_INTRUDERS,
    Encounter,
    Group,
    Navigation,
    Params,
    ParamsError,
    Ranging,
    Zone,
    choice,
    number,
    refuse_keywords,
    suggestion,
)
from rss_gym.schema import argument, whole

Driver = Literal["agent", "idm"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Road(Group):
    """What a road has beside the world's groups; `rss_gym.highway.RssRanging` says what the last three do.

    Parameters
    ----------
    scene : str
        One of `SCENES`.
    config : mapping
        What differs from the scene's configuration of highway-env.
    """

    scene: str = choice("highway", SCENES)
    config: Mapping[str, Any] = field(default_factory=dict, hash=False)
    radio_range_m: float = number(150.0, 0.1, 1e4)
    radio: bool = True
    driver: str = choice("agent", Driver)

    def __post_init__(self) -> None:
        """Check the fields; the configuration is checked where the road is made."""
        Group.__post_init__(self)
        object.__setattr__(self, "config", dict(_mapping("config", self.config)))

    @property
    def configuration(self) -> dict[str, Any]:
        """As highway-env takes it, but for its own defaults."""
        return {**SCENES[self.scene].configuration, **self.config}


ROAD = tuple(item.name for item in dataclasses.fields(Road))
# Groups that are given as tables, and what a road has of them; of the others all.
TABLES = {
    "zone": tuple(item.name for item in dataclasses.fields(Zone)),
    "ranging": tuple(item.name for item in dataclasses.fields(Ranging)),
    "navigation": ("gnss_m", "gnss_tc_s", "velocity_mps", "velocity_tc_s"),
    "reward": ("deviation_price", "snmac_price_m", "collision_price_m"),
}
KEYWORDS = (*ROAD, *TABLES, "vehicles", "channel", "information", "estimator")


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadParams(Params):
    """All parameters of a road. What it shares with the air stands in the same groups, some with other defaults."""

    # |v| of (40) is the relative speed of the fastest and the slowest of highway-env's vehicles, 30 and 20 m/s. With
    # the world's n_d = 8 the zone would be 120 m and hold everybody on the road for good; with n_d = 3, which bounds a
    # missed conflict by 0.2^3 = 0.008, it is (4 / 0.8 + 10 * 1) * 3 = 45 m.
    zone: Zone = field(default_factory=lambda: Zone(speed_relative_max_mps=10.0, collision_probability=1e-2))
    # Of a vehicle first heard, between the next one and the end of radio range.
    ranging: Ranging = field(default_factory=lambda: Ranging(prior_range_m=80.0))
    navigation: Navigation = field(default_factory=lambda: Navigation(agent="gnss", intruder="gnss"))
    encounter: Encounter = field(default_factory=lambda: Encounter(intruders=6))
    road: Road = field(default_factory=Road)

    @classmethod
    def of(
        cls,
        params: Params | Mapping[str, Any] | None = None,
        frequencies: tuple[float, float] | None = None,
        **keywords: Any,
    ) -> RoadParams:
        """`params` (the dataclass, its dict, or those of the scene) with any of `KEYWORDS` changed.

        Parameters
        ----------
        params : RoadParams or dict, optional
        frequencies : (float, float), optional
            The frequencies of the simulation and of the policy, Hz; default: those of the scene's configuration.
        vehicles : int
            How many of the nearest vehicles are observed, 1 to 8.
        channel : str, path, dict, Channel or a list of these
            As in the world; one is drawn an episode.
        information, estimator : str
            As in the world.
        zone, ranging, navigation, reward : dict
            Fields of these groups that differ.
        scene, config, radio_range_m, radio, driver
            As in `Road`.

        Raises
        ------
        ParamsError
            For an unknown name, with the nearest known one, or a value out of range.
        """
        refuse_keywords("a road", keywords, KEYWORDS)
        base = cls() if params is None else params if isinstance(params, cls) else cls.from_dict(params)  # type: ignore
        road = base.road.replace(**{name: value for name, value in keywords.items() if name in ROAD})
        changes: dict[str, Any] = {"road": road}
        if params is None or road.scene != base.road.scene:
            changes["zone"] = base.zone.replace(**SCENES[road.scene].zone)
        simulation, policy = frequencies or (road.configuration[f"{of}_frequency"] for of in ("simulation", "policy"))
        decision_s = int(simulation // policy) / simulation
        changes["clock"] = base.clock.replace(tick_s=1.0 / simulation, decision_s=decision_s)
        for name, known in TABLES.items():
            given = keywords.get(name)
            if given is not None:
                changes[name] = _changed(name, changes.get(name, getattr(base, name)), given, known)
        if "estimator" in keywords:
            changes["ranging"] = changes.get("ranging", base.ranging).replace(estimator=keywords["estimator"])
        if "vehicles" in keywords:
            vehicles = argument("vehicles", keywords["vehicles"], whole(1, MAX_INTRUDERS))
            changes["encounter"] = base.encounter.replace(intruders=vehicles)
        if "channel" in keywords:
            changes["channels"] = keywords["channel"]
        if "information" in keywords:
            level = keywords["information"]
            changes["interface"] = base.interface.replace(information=level)
            changes["tracking"] = base.tracking.replace(tracker="bearings" if level == "ranges" else "fused")
        return dataclasses.replace(base, **changes)

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> RoadParams:
        """The parameters that `to_dict` wrote."""
        rest = dict(_mapping("params", table))
        road = _mapping("params.road", rest.pop("road", {}))
        groups = Params.from_dict(rest)
        shared = {item.name: getattr(groups, item.name) for item in dataclasses.fields(groups)}
        return cls(road=Road().replace(**road), **shared)


def _changed(name: str, base: Group, given: Any, known: tuple[str, ...]) -> Group:
    """A group with some fields changed; errors name the group too."""
    if isinstance(given, type(base)):
        return given
    for parameter in _mapping(name, given):
        if parameter not in known:
            raise ParamsError(f"{name} has no parameter {parameter!r} on a road{suggestion(str(parameter), known)}")
    try:
        return base.replace(**given)
    except ParamsError as error:
        raise ParamsError(f"{name}: {error}") from error


def _mapping(name: str, given: Any) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise ParamsError(f"{name} must be a dict of parameters, got {given!r}")
    return given


@cache
def actions(params: RoadParams) -> tuple[str, ...]:
    """highway-env's names of the meta-actions in their order: LANE_LEFT, IDLE, LANE_RIGHT, FASTER, SLOWER, or fewer.

    Empty where the configuration has other actions.
    """
    kind = scene_class(SCENES[params.road.scene])  # which says so where highway-env is missing
    from highway_env.envs.common.action import action_factory

    config = {**kind.default_config(), **params.road.configuration}
    names = getattr(action_factory(None, config["action"]), "actions", {})
    return tuple(names[index] for index in sorted(names))
