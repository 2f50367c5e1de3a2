"""The orthogonal rule (43)-(45) on arrays of way points: as printed, and as the world flies it.

Positions have 2 or 3 coordinates, in axes whose z is up and whose y is to the right of x.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rss_gym.avoidance.orthogonal import TINY_M, displacement
from rss_gym.checks import finite
from rss_gym.jit import kernel
from rss_gym.params import ParamsError

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class WayPoints:
    """What the rule makes of U_j's next way points."""

    next_j_m: Floats  # (n, D): u_j(n+1), the predefined one where no action is due
    due: npt.NDArray[np.bool_]  # (n,): (44) holds, the predefined way points are closer than S
    changed: npt.NDArray[np.bool_]  # (n,): due, and (45) has a solution


def literal(
    position_i_m: npt.ArrayLike,
    next_i_m: npt.ArrayLike,
    velocity_i_mps: npt.ArrayLike,
    position_j_m: npt.ArrayLike,
    next_j_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
) -> WayPoints:
    """(43)-(45) as printed: the test is on the way points of n+1, the zone of (45) is that round u_i(n).

    U_i flies on while U_j goes to the edge of where its zone was: at n+1 the distance can fall short of S by up to the
    way U_i flies in one step. `flown` has the zone round u_i(n+1).

    Parameters
    ----------
    position_i_m, next_i_m : array_like, shape (n, D)
        u_i(n) and u_i(n+1), D = 2 or 3. A single row broadcasts against the others.
    velocity_i_mps : array_like, shape (n, D)
        v_i(n); only its direction matters.
    position_j_m, next_j_m : array_like, shape (n, D)
        u_j(n) and the predefined u_j^d(n+1).
    radius_m : array_like, shape () or (n,)
        S_ij, > 0: the smaller of the two zones' radii.

    Returns
    -------
    WayPoints

    Raises
    ------
    ParamsError
        When a shape or a value is wrong.

    Notes
    -----
    With r = u_j(n) - u_i(n), a = r . v_i / |v_i| and p = r - a v_i / |v_i|, the nearest point of (45) is
    u_i(n) + a v_i / |v_i| + sqrt(S^2 - a^2) p / |p|. Edges: p = 0 goes to the right of v_i in the horizontal plane (v_i
    vertical: along y); v_i = 0 goes along r, and along y if r = 0 as well; |a| > S, where (45) has no solution, keeps
    the predefined way point.
    """
    (u_i, next_i, v_i, u_j, next_j), radius, axes = _rows(
        radius_m,
        position_i_m=position_i_m,
        next_i_m=next_i_m,
        velocity_i_mps=velocity_i_mps,
        position_j_m=position_j_m,
        next_j_m=next_j_m,
    )
    speed = np.linalg.norm(v_i, axis=1, keepdims=True)
    forward = np.divide(v_i, speed, out=np.zeros_like(v_i), where=speed > 0.0)
    r = u_j - u_i
    a = np.sum(r * forward, axis=1, keepdims=True)
    p = r - a * forward
    length = np.linalg.norm(p, axis=1, keepdims=True)
    outward = np.where(length > TINY_M, p / np.maximum(length, TINY_M), _right(forward))
    reach = np.sqrt(np.maximum(radius[:, None] ** 2 - a * a, 0.0))
    due = np.linalg.norm(next_i - next_j, axis=1) < radius
    changed = due & (np.abs(a[:, 0]) <= radius)
    way_point = np.where(changed[:, None], u_i + a * forward + reach * outward, next_j)
    return WayPoints(way_point[:, :axes], due, changed)


def flown(
    next_i_m: npt.ArrayLike, velocity_i_mps: npt.ArrayLike, next_j_m: npt.ArrayLike, radius_m: npt.ArrayLike
) -> WayPoints:
    """The rule with the zone round u_i(n+1), which (43)-(44) test too: `orthogonal.displacement` of u_j^d(n+1).

    The distance at n+1 is then S wherever a way point is changed. Parameters, errors and edges as in `literal`; |a| > S
    does not occur.
    """
    (next_i, v_i, next_j), radius, axes = _rows(
        radius_m, next_i_m=next_i_m, velocity_i_mps=velocity_i_mps, next_j_m=next_j_m
    )
    r = next_j - next_i
    moved = np.empty_like(r)
    _displace(r, v_i, radius, moved)
    due = np.linalg.norm(r, axis=1) < radius
    return WayPoints((next_j + moved)[:, :axes], due, due.copy())


@kernel
def _displace(r_m, v_mps, radius_m, out):
    """`displacement` of every row, to the nearer side."""
    for n in range(len(r_m)):
        r, v = r_m[n], v_mps[n]
        x, y, z = displacement(r[0], r[1], r[2], v[0], v[1], v[2], radius_m[n], 0.0, 0.0, 0.0)
        out[n, 0], out[n, 1], out[n, 2] = x, y, z


def _right(forward: Floats) -> Floats:
    """Unit vectors to the right of `forward` (n, 3) in the horizontal plane, or along y where there is no right."""
    right = np.column_stack([-forward[:, 1], forward[:, 0], np.zeros(len(forward))])
    level = np.linalg.norm(right, axis=1, keepdims=True)
    return np.where(level > 0.0, right / np.where(level > 0.0, level, 1.0), [0.0, 1.0, 0.0])


def _rows(radius_m: npt.ArrayLike, **vectors: npt.ArrayLike) -> tuple[list[Floats], Floats, int]:
    """The vectors as (n, 3) arrays (z = 0 in the plane), the radius as (n,), and the number of coordinates."""
    arrays = {name: finite(name, value) for name, value in vectors.items()}
    axes = {array.shape[-1] if array.ndim == 2 else 0 for array in arrays.values()}
    lengths = {len(array) for array in arrays.values() if array.ndim == 2} - {1}
    radius = finite("radius_m", radius_m, 1e-9)
    lengths |= {len(radius)} - {1} if radius.ndim == 1 else set()
    if len(axes) != 1 or not axes <= {2, 3} or len(lengths) > 1 or radius.ndim > 1:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in {**arrays, "radius_m": radius}.items())
        raise ParamsError(
            f"positions and velocities must all be (n, 2) or all (n, 3), radius_m () or (n,), got {shapes}"
        )
    n = lengths.pop() if lengths else 1
    width = axes.pop()
    padded = [np.zeros((n, 3)) for _ in arrays]
    for row, array in zip(padded, arrays.values(), strict=True):
        row[:, :width] = array
    return padded, np.broadcast_to(radius, n).copy(), width
