"""What a family of encounters is: the ranges that the sampler draws from, as data."""

from dataclasses import asdict, dataclass
from math import pi
from typing import Any

import numpy as np

from rss_gym.params import ParamsError
from rss_gym.state import FAMILY

TURN_S = (6.0, 20.0)  # before the closest approach, where the intruder turns
# The agent turns at any time of the flight: a turn of its own plan must not tell when the closest approach is.
OWN_TURN_S = (-20.0, 40.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Script:
    """One hand-written encounter, laid from its start: the only family that may break the limits of the others.

    Parameters
    ----------
    own_mps : float
        Speed of the agent, which starts at the origin; its heading is drawn.
    start_m : (float, float, float)
        Where the intruder starts: along the agent's heading, to the right of it, up.
    velocity_mps : (float, float)
        The intruder's velocity along and to the right.
    end_s : float
        Length of the flight.
    """

    own_mps: float
    start_m: tuple[float, float, float]
    velocity_mps: tuple[float, float]
    end_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Complication:
    """What the intruder or its link does that straight and honest flight over a steady link does not prepare for.

    All ranges are uniform; angles, changes of speed and jumps have a random sign. None leaves a thing out.

    Parameters
    ----------
    bend_s : (float, float)
        When a turn, a change of speed or a false announcement begins, before the planned closest approach. In the
        default world up to 12 s are always within the safety zone.
    turn_rad : (float, float) or None
        Size of a turn that the intruder alone makes.
    speed_change_mps : (float, float) or None
        Change of its cruise speed, within the limits of cruise speeds; the autopilot makes a ramp of it.
    announced_rad : (float, float) or None
        Turn that its messages tell, velocity and next way point, while it flies straight on.
    merging : bool
        Intruders reach the agent's path one after another, but for their miss distances, and go on along the course
        of the first; they are planned to stay clear of each other.
    onset_s : (float, float)
        When a jump or an outage begins, after the planned entry into the safety zone.
    path_loss_jump : (float, float) or None
        Lasting change of the link's true path loss factor.
    outage_s : (float, float) or None
        How long the link carries neither RSS nor messages.
    """

    bend_s: tuple[float, float] = (4.0, 12.0)
    turn_rad: tuple[float, float] | None = None
    speed_change_mps: tuple[float, float] | None = None
    announced_rad: tuple[float, float] | None = None
    merging: bool = False
    onset_s: tuple[float, float] = (-5.0, 5.0)
    path_loss_jump: tuple[float, float] | None = None
    outage_s: tuple[float, float] | None = None

    @property
    def bends(self) -> bool:
        """Whether the intruder's path needs a way point on its way."""
        return self.merging or any((self.turn_rad, self.speed_change_mps, self.announced_rad))


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """How the encounters of a family are drawn, built from the planned closest approach backwards.

    Parameters
    ----------
    summary : str
        One line for `rss-gym list`.
    weight : float
        Share in `mixed`, relative to the other families; 0 keeps it out of `mixed`, to be named explicitly.
    crossing_rad : (float, float)
        Angle from the agent's heading to the intruder's at the closest approach; the side is drawn.
    conflict_share : float
        Share with a planned miss distance small enough to collide.
    offset_m : (float, float) or None
        Horizontal miss distance of the others, the side drawn; None takes +-`horizontal_offset_m` of the parameters.
    turn_rad : (float, float) or None
        Size of a turn, the side drawn, that each aircraft makes, so that a straight extrapolation fails: the intruder
        6-20 s before the closest approach, the agent from 40 s before to 20 s after it. None flies straight.
    faster : bool
        The intruder is faster than the agent.
    script : Script or None
        A hand-written encounter, which makes the ranges above void.
    complication : Complication or None
        What else the intruder or its link does; not together with `turn_rad`.
    """

    summary: str
    weight: float
    crossing_rad: tuple[float, float] = (0.0, 0.0)
    conflict_share: float = 0.0
    offset_m: tuple[float, float] | None = None
    turn_rad: tuple[float, float] | None = None
    faster: bool = False
    script: Script | None = None
    complication: Complication | None = None

    def __post_init__(self) -> None:
        """Check that turns are described in one place only."""
        if self.turn_rad is not None and self.complication is not None:
            raise ParamsError(f"turn_rad = {self.turn_rad} must be None beside a complication, which has its own")

    @property
    def definition(self) -> dict[str, Any]:
        """Everything that a suite's hash covers, as plain types."""
        return asdict(self)

    def record(self, horizontal_offset_m: float) -> np.void:
        """The family as the record that the sampler reads; `weight` is not yet cumulative."""
        out, more = np.zeros(1, FAMILY)[0], self.complication or Complication(bend_s=TURN_S, turn_rad=self.turn_rad)
        out["weight"], out["conflict_share"] = self.weight or 1.0, self.conflict_share
        out["crossing_min_rad"], out["crossing_max_rad"] = self.crossing_rad
        out["offset_min_m"], out["offset_max_m"] = self.offset_m or (0.0, horizontal_offset_m)
        out["bends"], out["merging"], out["faster"] = more.bends, more.merging, self.faster
        out["own_bend_min_s"], out["own_bend_max_s"] = OWN_TURN_S
        for name, unit, given in (
            ("own_turn", "_rad", self.turn_rad),
            ("bend", "_s", more.bend_s),
            ("turn", "_rad", more.turn_rad),
            ("speed_change", "_mps", more.speed_change_mps),
            ("announced", "_rad", more.announced_rad),
            ("onset", "_s", more.onset_s),
            ("jump", "", more.path_loss_jump),
            ("outage", "_s", more.outage_s),
        ):
            out[f"{name}_min{unit}"], out[f"{name}_max{unit}"] = given or (0.0, 0.0)
        if self.script is not None:
            out["scripted"], out["own_mps"], out["end_s"] = True, self.script.own_mps, self.script.end_s
            out["start_m"], out["velocity_mps"] = self.script.start_m, self.script.velocity_mps
        return out


def degrees(low: float, high: float) -> tuple[float, float]:
    """A range of angles given in degrees, in radians."""
    return low * pi / 180.0, high * pi / 180.0
