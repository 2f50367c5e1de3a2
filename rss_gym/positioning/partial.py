"""What ranges to fewer than three reference nodes can tell about a position (Sec. IX-A, J < 3)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from rss_gym.checks import finite
from rss_gym.params import ParamsError

Shape = Literal["anywhere", "circle", "sphere", "points"]
Floats = npt.NDArray[np.float64]

_WARNING = "The distance to each node is known, so a violation of the safety zone (29) is still seen"


@dataclass(frozen=True)
class Locus:
    """The set of positions that fit the ranges; D = 2 or 3 coordinates."""

    shape: Shape
    sentence: str  # what is known and what is not
    centre_m: Floats | None = None  # (D,), of the circle or sphere
    radius_m: float | None = None  # of the circle or sphere
    normal: Floats | None = None  # (3,), unit vector at right angles to the plane of a circle in space
    points_m: Floats | None = None  # (1 or 2, D)
    gap_m: float = 0.0  # by how much the two ranges fail to meet; the point between is given then


def partial(nodes_m: npt.ArrayLike, ranges_m: npt.ArrayLike) -> Locus:
    """Where ranges to no, one or two nodes allow an aircraft to be.

    Parameters
    ----------
    nodes_m : array_like, shape (J, 2) or (J, 3)
        Positions of J <= 2 reference nodes; `numpy.empty((0, 2))` for none.
    ranges_m : array_like, shape (J,)
        Ranges to them, >= 0.

    Returns
    -------
    Locus
        No node: anywhere. One: a circle (a sphere in space). Two: two points, mirrored in the line through the nodes
        (a circle round that line in space); one point if the ranges just meet or, being wrong, do not meet at all.

    Raises
    ------
    ParamsError
        When a shape or value is wrong, there are more than two nodes, or the two nodes are at one point.
    """
    nodes, ranges = finite("nodes_m", nodes_m), finite("ranges_m", ranges_m, 0.0)
    if nodes.ndim != 2 or nodes.shape[1] not in (2, 3) or ranges.shape != nodes.shape[:1]:
        raise ParamsError(
            f"nodes_m must have the shape (J, 2) or (J, 3) and ranges_m (J,), got {nodes.shape} and {ranges.shape}"
        )
    planar = nodes.shape[1] == 2
    if len(nodes) == 0:
        return Locus("anywhere", "Without a reference node neither the position nor any distance is known.")
    if len(nodes) == 1:
        shape: Shape = "circle" if planar else "sphere"
        sentence = f"One node leaves a {shape} round it: no direction is known. {_WARNING}."
        return Locus(shape, sentence, centre_m=nodes[0], radius_m=float(ranges[0]))
    if len(nodes) == 2:
        return _two(nodes, ranges, planar)
    raise ParamsError(f"nodes_m must hold at most two nodes, got {len(nodes)}; positioning.fix takes three or more")


def _two(nodes: Floats, ranges: Floats, planar: bool) -> Locus:
    apart = float(np.linalg.norm(nodes[1] - nodes[0]))
    if apart == 0.0:
        raise ParamsError("nodes_m must be two different points; of two nodes at one point leave one out")
    axis = (nodes[1] - nodes[0]) / apart
    one, two = float(ranges[0]), float(ranges[1])
    gap = max(apart - one - two, abs(one - two) - apart)
    if gap >= 0.0:
        # Along the line the ranges lead to one + two >= apart from either end, or to the same side of both nodes:
        # halfway between the two ends.
        ends = (one, apart - two) if apart >= one + two else (one, apart + two) if one > two else (-one, apart - two)
        point = nodes[0] + 0.5 * sum(ends) * axis
        meeting = "meet in one point" if gap == 0.0 else f"fail to meet by {gap:.3g} m; the point between is given"
        sentence = f"The two ranges {meeting}, on the line through the nodes. {_WARNING}."
        return Locus("points", sentence, points_m=point[None], gap_m=gap)
    along = (apart * apart + one * one - two * two) / (2.0 * apart)
    centre, radius = nodes[0] + along * axis, float(np.sqrt(max(one * one - along * along, 0.0)))
    if planar:
        offset = radius * np.array([-axis[1], axis[0]])
        sentence = (
            f"Two nodes leave two points, mirrored in the line through the nodes: a rough position, or the way flown, "
            f"has to choose. {_WARNING}."
        )
        return Locus("points", sentence, points_m=np.array([centre + offset, centre - offset]))
    sentence = (
        f"Two nodes leave a circle round the line through them; with the altitude known, at most two points of it "
        f"remain. {_WARNING}."
    )
    return Locus("circle", sentence, centre_m=centre, radius_m=radius, normal=axis)
