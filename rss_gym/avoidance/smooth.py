"""Way points joined by a smooth curve, as Sec. VII and IX-C propose ("higher order polynomial approximation").

Velocity and acceleration are continuous. A curve bends outside the straight lines between the way points, so limits
and the distance to others are checked on the curve; both checks are exact, by the roots of polynomials.
"""

from dataclasses import dataclass
from math import factorial
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rss_gym.checks import finite, single
from rss_gym.params import ParamsError

Kind = Literal["cubic", "quintic"]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """A piecewise polynomial through the way points; `smooth` makes it."""

    time_s: Floats  # (n,)
    curve: Any  # scipy.interpolate.PPoly of positions (m)

    def position_m(self, time_s: npt.ArrayLike) -> Floats:
        """Position (..., D) at times (...) between the first and the last way point."""
        return self._at(time_s, 0)

    def velocity_mps(self, time_s: npt.ArrayLike) -> Floats:
        """Velocity (..., D) at times (...)."""
        return self._at(time_s, 1)

    def acceleration_mps2(self, time_s: npt.ArrayLike) -> Floats:
        """Acceleration (..., D) at times (...)."""
        return self._at(time_s, 2)

    def _at(self, time_s: npt.ArrayLike, order: int) -> Floats:
        return self.curve(finite("time_s", time_s, self.time_s[0], self.time_s[-1]), order)

    @property
    def speed_max_mps(self) -> float:
        """Largest speed anywhere on the curve."""
        return self._largest(1)

    @property
    def acceleration_max_mps2(self) -> float:
        """Largest acceleration anywhere on the curve."""
        return self._largest(2)

    def _largest(self, order: int) -> float:
        squares, times = _squares(_pieces(self.curve.derivative(order), self.time_s[:-1]), self.time_s)
        return float(np.sqrt(squares(times).max()))

    def breach(self, speed_max_mps: float, acceleration_max_mps2: float) -> str:
        """A sentence on the limits that the curve exceeds, empty if it keeps both (to one part in 10^9)."""
        kept = (
            ("speed", self.speed_max_mps, single("speed_max_mps", speed_max_mps, 0.0), "m/s"),
            (
                "acceleration",
                self.acceleration_max_mps2,
                single("acceleration_max_mps2", acceleration_max_mps2, 0.0),
                "m/s^2",
            ),
        )
        beyond = [
            f"its {name} reaches {value:.4g} {unit}, above the limit of {limit:.4g} {unit}"
            for name, value, limit, unit in kept
            if value > limit * (1.0 + 1e-9)
        ]
        return f"The trajectory cannot be flown: {' and '.join(beyond)}." if beyond else ""


@dataclass(frozen=True)
class Separation:
    """The closest approach of two trajectories."""

    distance_m: float
    time_s: float

    def respects(self, radius_m: float) -> bool:
        """Whether the distance never falls below `radius_m` (to one part in 10^9)."""
        return self.distance_m >= single("radius_m", radius_m, 0.0) * (1.0 - 1e-9)


def smooth(
    time_s: npt.ArrayLike,
    points_m: npt.ArrayLike,
    kind: Kind = "quintic",
    start_mps: npt.ArrayLike | None = None,
    end_mps: npt.ArrayLike | None = None,
) -> Trajectory:
    """A smooth trajectory through way points.

    Parameters
    ----------
    time_s : array_like, shape (n,)
        Times of n >= 2 way points, increasing.
    points_m : array_like, shape (n, D)
        The way points, D = 2 or 3.
    kind : {"quintic", "cubic"}
        "quintic": each piece matches position, velocity and acceleration at its ends, taken from the parabola through a
        way point and its two neighbours, with no acceleration at the first and last; a moved way point is felt four
        pieces around. "cubic": the cubic spline, the least mean square acceleration; each way point is felt everywhere.
    start_mps, end_mps : array_like, shape (D,), optional
        Velocities at the first and last way point; if not given those of the straight line there.

    Raises
    ------
    ParamsError
        When a shape, a value or the order of the times is wrong.
    """
    time, points = finite("time_s", time_s), finite("points_m", points_m)
    if time.ndim != 1 or len(time) < 2 or points.ndim != 2 or len(points) != len(time) or points.shape[1] not in (2, 3):
        raise ParamsError(
            f"time_s must have the shape (n,), n >= 2, and points_m (n, 2) or (n, 3), "
            f"got {time.shape} and {points.shape}"
        )
    interval = np.diff(time)
    if not (interval > 0.0).all():
        raise ParamsError(
            f"time_s must increase, got {time[np.argmin(interval) + 1]:g} after {time[np.argmin(interval)]:g}"
        )
    if kind not in get_args(Kind):
        raise ParamsError(f"kind must be 'quintic' or 'cubic', got {kind!r}")
    from scipy.interpolate import BPoly, CubicSpline, PPoly

    chord = np.diff(points, axis=0) / interval[:, None]
    ends = [
        chord[at] if given is None else finite(name, given)
        for name, given, at in (("start_mps", start_mps, 0), ("end_mps", end_mps, -1))
    ]
    for name, end in zip(("start_mps", "end_mps"), ends, strict=True):
        if end.shape != points.shape[1:]:
            raise ParamsError(f"{name} must have the shape {points.shape[1:]}, got {end.shape}")
    if kind == "cubic":
        return Trajectory(time, CubicSpline(time, points, bc_type=((1, ends[0]), (1, ends[1]))))
    # The parabola through three way points: its slope and bend at the middle one.
    before, after = interval[:-1, None], interval[1:, None]
    velocity = np.vstack([ends[0], (chord[:-1] * after + chord[1:] * before) / (before + after), ends[1]])
    bend = 2.0 * np.diff(chord, axis=0) / (before + after)
    acceleration = np.vstack([np.zeros_like(ends[0]), bend, np.zeros_like(ends[1])])
    curve = BPoly.from_derivatives(time, np.stack([points, velocity, acceleration], axis=1))
    return Trajectory(time, PPoly.from_bernstein_basis(curve))


def separation(one: Trajectory, two: Trajectory) -> Separation:
    """The least distance of two trajectories over the time that both cover, and when it is reached first.

    Raises
    ------
    ParamsError
        When they have no time in common, or one is in the plane and the other in space.
    """
    if one.curve.c.shape[2] != two.curve.c.shape[2]:
        raise ParamsError("the two trajectories must have the same number of coordinates, got 2 and 3")
    begin, end = max(one.time_s[0], two.time_s[0]), min(one.time_s[-1], two.time_s[-1])
    if begin >= end:
        raise ParamsError(
            f"the trajectories must overlap in time, but one ends at {end:g} s and the other starts at {begin:g} s"
        )
    every = np.union1d(one.time_s, two.time_s)
    breaks = every[(every >= begin) & (every <= end)]
    a, b = _pieces(one.curve, breaks[:-1]), _pieces(two.curve, breaks[:-1])
    degree = max(len(a), len(b))
    a, b = (np.concatenate([np.zeros((degree - len(c), *c.shape[1:])), c]) for c in (a, b))
    squares, times = _squares(a - b, breaks)
    distances = squares(times)
    nearest = int(np.argmin(distances))
    return Separation(float(np.sqrt(max(distances[nearest], 0.0))), float(times[nearest]))


def _pieces(curve: Any, starts: Floats) -> Floats:
    """Coefficients (degree + 1, m, D), highest power first, of a curve seen from `starts` (m,)."""
    degree = len(curve.c) - 1
    return np.array([curve(starts, k) / factorial(k) for k in range(degree, -1, -1)])


def _squares(pieces: Floats, breaks: Floats) -> tuple[Any, Floats]:
    """The squared length of a curve as a piecewise polynomial, and the times at which it can be largest or least."""
    from scipy.interpolate import PPoly

    degree = len(pieces) - 1
    square = np.zeros((2 * degree + 1, pieces.shape[1]))
    for i in range(degree + 1):
        square[i : i + degree + 1] += np.sum(pieces[i] * pieces, axis=-1)
    curve = PPoly(square, breaks)
    roots = curve.derivative().roots(discontinuity=False, extrapolate=False)
    return curve, np.union1d(breaks, roots[np.isfinite(roots)])
