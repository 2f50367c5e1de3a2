"""What a family of encounters is: the ranges that the sampler draws from, as data."""

from dataclasses import dataclass
from math import pi

import numpy as np

from rss_gym.records import FAMILY


@dataclass(frozen=True, slots=True, kw_only=True)
class Script:
    """One hand-written encounter, laid from its start: the only law that may break the limits of the others.

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
class Family:
    """A law of encounters, built from the planned closest approach backwards.

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
        Size of a turn, the side drawn, that each aircraft makes 6-20 s before the closest approach, so that a straight
        extrapolation fails; None flies straight.
    script : Script or None
        A hand-written encounter, which makes the ranges above void.
    """

    summary: str
    weight: float
    crossing_rad: tuple[float, float] = (0.0, 0.0)
    conflict_share: float = 0.0
    offset_m: tuple[float, float] | None = None
    turn_rad: tuple[float, float] | None = None
    script: Script | None = None

    def record(self, horizontal_offset_m: float) -> np.void:
        """The family as the record that the sampler reads; `weight` is not yet cumulative."""
        out = np.zeros(1, FAMILY)[0]
        out["weight"], out["conflict_share"] = self.weight or 1.0, self.conflict_share
        out["crossing_min_rad"], out["crossing_max_rad"] = self.crossing_rad
        out["offset_min_m"], out["offset_max_m"] = self.offset_m or (0.0, horizontal_offset_m)
        out["turns"] = self.turn_rad is not None
        out["turn_min_rad"], out["turn_max_rad"] = self.turn_rad or (0.0, 0.0)
        if self.script is not None:
            out["scripted"], out["own_mps"], out["end_s"] = True, self.script.own_mps, self.script.end_s
            out["start_m"], out["velocity_mps"] = self.script.start_m, self.script.velocity_mps
        return out


def degrees(low: float, high: float) -> tuple[float, float]:
    """A range of angles given in degrees, in radians."""
    return low * pi / 180.0, high * pi / 180.0
