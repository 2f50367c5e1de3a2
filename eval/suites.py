"""Suites: frozen, hashed definitions of what is flown.

A new suite is one line in `SUITES`, or `rss_gym.register_suite`. The hash covers the parameters, the families of
encounters or the road, and the version of the world, so scores of two definitions can never be mixed up.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass, field
from typing import Any

from rss_gym import encounters
from rss_gym.core import SPLITS
from rss_gym.domain import Domain, domain_of
from rss_gym.highway.params import RoadParams
from rss_gym.highway.scene import SCENES
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.registry import Registry


@dataclass(frozen=True, slots=True)
class Suite:
    """A benchmark: a world, the split and seed of its episodes, and how many count as official.

    Parameters
    ----------
    name, summary : str
    params : Params
        The world; a policy may only change the part of it that is its interface.
    episodes : int
        Encounters of an official run.
    """

    name: str
    summary: str
    params: Params = field(default_factory=Params)
    episodes: int = 100_000
    split: str = "suite"
    seed: int = 0

    @property
    def domain(self) -> Domain:
        """Air or road."""
        return domain_of(self.params)

    @property
    def families(self) -> list[str]:
        """Names of the families drawn from; the episode table holds indices into this list."""
        return self.domain.families(self.params)

    @property
    def definition(self) -> dict[str, Any]:
        """Everything that the hash covers, as plain JSON types."""
        common = {"name": self.name, "params": self.params.to_dict(), "split": self.split}
        return common | self.domain.definition(self.params)

    @property
    def hash(self) -> str:
        """SHA-256 of the definition, hexadecimal."""
        return hashlib.sha256(json.dumps(self.definition, sort_keys=True).encode()).hexdigest()

    def changed(self, **keywords: Any) -> Suite:
        """The suite with other parameters; a change changes the hash, and such runs are not official."""
        return dataclasses.replace(self, params=Params.of(self.params, **keywords)) if keywords else self


DEGENERATE = [name for name in encounters.FAMILIES.shipped if encounters.FAMILIES[name].script is not None]
SEPARATING = ["near-parallel", "late-turn", "accelerating", "deceitful", "path-loss-jump", "outage"]

_SHIPPED = (
    Suite("encounter-v0", "the default world, planar: nobody has GNSS"),
    Suite("encounter3d-v0", "the default world in space", Params.of(planar=False)),
    Suite("range-only-v0", "ranges and velocities, no positions", Params.of(information="ranges")),
    Suite("gnss-v0", "agent and intruder know where they are by GNSS", Params.of(agent="gnss", intruder="gnss")),
    # On a slow radio two fixes between distant nodes err by 35 m a side, and nobody is safer than who flees: these
    # suites give the intruder GNSS, and `quadcopter-v0` nearer nodes (`rss-gym study world`).
    Suite(
        "radios-v0",
        "a radio drawn for each encounter: presets and random ones; the intruder has GNSS",
        Params.of(channel="radios", intruder="gnss"),
    ),
    Suite(
        "quadcopter-v0",
        "the channel of a real telemetry link; the intruder has GNSS, nodes 200 m apart",
        Params.of(channel="quadcopter", intruder="gnss", node_square_m=200.0),
    ),
    Suite("turning-v0", "both aircraft turn, the intruder before the closest approach", Params.of(families="turning")),
    Suite("degenerate-v0", "hand-written corners of the geometry", Params.of(families=DEGENERATE), episodes=1000),
    Suite("separating-v0", "families that tell the rules apart, in equal shares", Params.of(families=SEPARATING)),
    Suite(
        "merging-v0",
        "2-8 intruders that merge where the agent crosses",
        Params.of(families="merging", intruders=8, intruders_min=2),
    ),
    Suite("smoke-v0", "100 encounters, for continuous integration", episodes=100),
    *(Suite(f"{name}-v0", scene.summary, RoadParams.of(scene=name), 1000) for name, scene in SCENES.items()),
)


def _check(name: str, suite: Suite) -> None:
    if not isinstance(suite, Suite):
        raise ParamsError(f"suite must be a rss_gym.eval.suites.Suite, got {type(suite).__name__}")
    if not suite.summary.strip():
        raise ParamsError(f"suite {name!r} must have a summary, one line for listings")
    if isinstance(suite.episodes, bool) or not isinstance(suite.episodes, int) or suite.episodes < 1:
        raise ParamsError(f"suite {name!r}: episodes must be a whole number >= 1, got {suite.episodes!r}")
    if suite.split not in SPLITS:
        raise ParamsError(f"suite {name!r}: split {suite.split!r} is unknown{suggestion(str(suite.split), SPLITS)}")
    _ = suite.families  # refuses those that are unknown


SUITES: Registry[Suite] = Registry(
    "suite", {suite.name: suite for suite in _SHIPPED}, _check, name=r"[a-z][a-z0-9-]*-v\d+", like="my-suite-v0"
)


def find(name: str) -> Suite:
    """The suite of that name.

    Raises
    ------
    ParamsError
        For an unknown name.
    """
    return SUITES.find(name)
