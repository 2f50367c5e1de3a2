"""The parameters of a road: the world's, with the group `road`, and set by the names that a road knows."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

from rss_gym.checks import positive
from rss_gym.highway.scene import SCENES, scene_class
from rss_gym.highway.settings import NAVIGATED, PRICES, mapping, prices, settings
from rss_gym.params import Group, Params, ParamsError, choice, refuse_keywords, suggestion

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

    scene: str = "highway"
    config: Mapping[str, Any] = field(default_factory=dict, hash=False)
    radio_range_m: float = 150.0
    radio: bool = True
    driver: str = choice("agent", Driver)

    def __post_init__(self) -> None:
        """Check the names; the configuration is checked where the road is made."""
        Group.__post_init__(self)
        if not isinstance(self.scene, str) or self.scene not in SCENES:
            raise ParamsError(f"scene {self.scene!r} is unknown{suggestion(str(self.scene), SCENES)}")
        object.__setattr__(self, "config", dict(mapping("config", self.config)))
        object.__setattr__(self, "radio_range_m", positive("radio_range_m", self.radio_range_m, 1e4))

    @property
    def configuration(self) -> dict[str, Any]:
        """As highway-env takes it, but for its own defaults."""
        return {**SCENES[self.scene].configuration, **self.config}

    @property
    def of_the_wrapper(self) -> dict[str, Any]:
        """What `RssRanging` takes."""
        return {"radio_range_m": self.radio_range_m, "radio": self.radio, "driver": self.driver}


ROAD = tuple(item.name for item in dataclasses.fields(Road))
KEYWORDS = (*ROAD, "vehicles", "channel", "information", "estimator", "zone", "ranging", "navigation", "reward")


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadParams(Params):
    """All parameters of a road. What it shares with the air stands in the same groups."""

    road: Road = field(default_factory=Road)

    @classmethod
    def of(cls, params: Params | Mapping[str, Any] | None = None, **keywords: Any) -> RoadParams:
        """`params` (the dataclass, its dict, or those of the scene) with any of `KEYWORDS` changed.

        `zone`, `ranging`, `navigation` and `reward` are tables of what differs; `vehicles` is how many are observed.

        Raises
        ------
        ParamsError
            For an unknown name, with the nearest known one, or a value out of range.
        """
        refuse_keywords("a road", keywords, KEYWORDS)
        base = params if params is None or isinstance(params, RoadParams) else cls.from_dict(params)  # type: ignore
        road = (base.road if base else Road()).replace(**{k: v for k, v in keywords.items() if k in ROAD})
        now: dict[str, Any] = {"zone": SCENES[road.scene].zone, "reward": {}}
        if base is not None:
            now = {
                "vehicles": base.encounter.intruders,
                "channel": list(base.channels),
                "information": base.interface.information,
                "estimator": base.ranging.estimator,
                "zone": base.zone.to_dict() | ({} if road.scene == base.road.scene else SCENES[road.scene].zone),
                "ranging": {k: v for k, v in base.ranging.to_dict().items() if k != "estimator"},
                "navigation": {name: getattr(base.navigation, name) for name in NAVIGATED},
                "reward": {name: getattr(base.reward, name) for name in PRICES},
            }
        for name, value in keywords.items():
            if name in ("zone", "ranging", "navigation", "reward"):
                value = {**now.get(name, {}), **mapping(name, {} if value is None else value)}
            if name not in ROAD:
                now[name] = value
        reward, frequency = prices(now.pop("reward")), road.configuration["simulation_frequency"]
        ticks = int(frequency // road.configuration["policy_frequency"])
        found = settings(1.0 / frequency, ticks / frequency, **now)
        groups = {item.name: getattr(found, item.name) for item in dataclasses.fields(found)}
        return cls(**{**groups, "reward": reward, "road": road})

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> RoadParams:
        """The parameters that `to_dict` wrote."""
        rest = dict(mapping("params", table))
        road = mapping("params.road", rest.pop("road", {}))
        groups = Params.from_dict(rest)
        shared = {item.name: getattr(groups, item.name) for item in dataclasses.fields(groups)}
        return cls(road=Road().replace(**road), **shared)


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
