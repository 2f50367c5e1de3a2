"""Suites of the roads: frozen, hashed definitions of what is driven."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any, ClassVar

from rss_gym.eval.suites import Suite
from rss_gym.highway.env import SCENES
from rss_gym.highway.settings import settings
from rss_gym.params import ParamsError

ROAD_VERSION = 0  # raised whenever a road gives other numbers for the same parameters
CHANGES = ("channel", "information", "estimator")  # what a run may change


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadSuite(Suite):
    """A benchmark on a road; `keywords` are those of `RoadEnv` that are not its defaults."""

    scene: str
    keywords: dict[str, Any] = field(default_factory=dict)

    packages: ClassVar[tuple[str, ...]] = ("highway-env",)

    @property
    def families(self) -> list[str]:
        """The scene, as the one family."""
        return [self.scene]

    @property
    def definition(self) -> dict[str, Any]:
        """Everything that the hash covers, as plain JSON types."""
        scene = SCENES[self.scene]
        return {
            "name": self.name,
            "road_version": ROAD_VERSION,
            "scene": scene.name,
            "config": scene.configuration,
            "params": self.params.to_dict(),
            "split": self.split,
        }

    def changed(self, **keywords: Any) -> RoadSuite:
        """The suite with another channel, information or estimator; such runs are not official."""
        for name in keywords:
            if name not in CHANGES:
                raise ParamsError(f"suite {self.name!r} is a road's, where only {', '.join(CHANGES)} can be changed")
        changed = {**self.keywords, **keywords}
        return dataclasses.replace(self, keywords=changed, params=_params(self.scene, changed)) if keywords else self


def _params(scene: str, keywords: dict[str, Any]) -> Any:
    found = SCENES[scene]
    frequency, decisions = found.configuration["simulation_frequency"], found.configuration["policy_frequency"]
    return settings(1.0 / frequency, 1.0 / decisions, zone=found.zone, **keywords)


def _suite(scene: str) -> RoadSuite:
    return RoadSuite(f"{scene}-v0", SCENES[scene].summary, _params(scene, {}), episodes=1000, scene=scene)


SUITES: dict[str, RoadSuite] = {suite.name: suite for suite in map(_suite, SCENES)}
