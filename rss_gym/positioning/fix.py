"""Trilateration (1) from three or more reference nodes, in the plane or in space, with covariance and conditioning.

Weighted least squares of the ranges by Levenberg-Marquardt with exact second derivatives, from several closed-form
beginnings, a batch of epochs at a time. `trilateration` holds the world's own kernel: three nodes, known altitude.
"""

from dataclasses import dataclass
from numbers import Integral

import numpy as np
import numpy.typing as npt

from rss_gym.checks import finite, together
from rss_gym.params import ParamsError

STEPS = 100
CONDITION_MAX = 1e4  # of the directions to the nodes; beyond it a range error of 1 cm moves the position by 100 m
AMBIGUOUS = 9.0  # weighted squares: two minima closer than this differ by less than three standard deviations

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Fix:
    """Positions of D = 2 or 3 coordinates from ranges; arrays have the epochs' axis in front if the input had it."""

    position_m: Floats  # (..., D)
    covariance_m2: Floats  # (..., D, D), first order
    residual_m: Floats  # (..., J): range minus distance from the position, also of nodes that were not used
    dilution: Floats  # (...): GDOP, root of the trace of the covariance that range errors of 1 m would give
    condition: Floats  # (...): condition number of the directions to the nodes
    mirror_m: Floats  # (..., D): the other position that explains the ranges as well, NaN where there is none

    @property
    def ambiguous(self) -> npt.NDArray[np.bool_]:
        """Where `mirror_m` holds a second position."""
        return np.asarray(np.isfinite(self.mirror_m).all(axis=-1))

    @property
    def degenerate(self) -> npt.NDArray[np.bool_]:
        """Where the position is next to the line or plane of the nodes, so that its distance from it is not known."""
        return np.asarray(self.condition > CONDITION_MAX)


def fix(
    nodes_m: npt.ArrayLike,
    ranges_m: npt.ArrayLike,
    range_std_m: npt.ArrayLike = 1.0,
    node_std_m: npt.ArrayLike = 0.0,
    prior_m: npt.ArrayLike | None = None,
    strongest: int | None = None,
) -> Fix:
    """Position from at least three ranges: (1) in the least-squares sense.

    Parameters
    ----------
    nodes_m : array_like, shape (J, D) or (n, J, D)
        Positions of J >= 3 reference nodes, D = 2 or 3; of n epochs if they move.
    ranges_m : array_like, shape (J,) or (n, J)
        Ranges to them, >= 0.
    range_std_m : array_like, broadcast to the ranges
        Standard deviations of the ranges, > 0. All 1 m if not given: the covariance is then that of 1 m.
    node_std_m : array_like, broadcast to the ranges
        Standard deviation of the nodes' positions per axis; to first order it adds to the range's variance.
    prior_m : array_like, shape (D,) or (n, D), optional
        A rough position. It says which of two mirrored positions is meant and is no measurement. Without it the better
        of the two is returned, and of two as good as each other the higher (its last coordinate is the larger).
    strongest : int, optional
        Use only that many of the nodes, at each epoch those of the strongest signals (Sec. IX-A: three), which are
        those of the shortest ranges.

    Returns
    -------
    Fix

    Raises
    ------
    ParamsError
        When a shape, a value or the number of nodes is wrong, or when at some epoch the nodes leave more than two
        positions: all at one point in the plane, all on one line in space.
    """
    nodes, ranges = finite("nodes_m", nodes_m), finite("ranges_m", ranges_m, 0.0)
    if nodes.ndim not in (2, 3) or nodes.shape[-1] not in (2, 3) or ranges.ndim not in (1, 2):
        raise ParamsError(
            f"nodes_m must have the shape (J, 2), (J, 3), (n, J, 2) or (n, J, 3) and ranges_m (J,) or (n, J), "
            f"got {nodes.shape} and {ranges.shape}"
        )
    count, axes = nodes.shape[-2:]
    if ranges.shape[-1] != count or count < 3:
        raise ParamsError(
            f"ranges_m must hold one range to each of three or more nodes, got {ranges.shape[-1]} ranges and {count} "
            f"nodes; positioning.partial says what fewer can tell"
        )
    batched = nodes.ndim == 3 or ranges.ndim == 2
    epochs = len(nodes) if nodes.ndim == 3 else len(ranges) if batched else 1
    shape = (epochs, count)
    nodes, ranges = _to("nodes_m", nodes, (*shape, axes)), _to("ranges_m", ranges, shape)
    range_std, node_std = together(range_std_m=(range_std_m, 1e-9), node_std_m=(node_std_m, 0.0))
    weights = 1.0 / _to("range_std_m and node_std_m", range_std**2 + node_std**2, shape)
    prior = None if prior_m is None else _to("prior_m", finite("prior_m", prior_m), (epochs, axes))

    used_nodes, used_ranges = nodes, ranges
    if strongest is not None:
        if isinstance(strongest, bool) or not isinstance(strongest, Integral) or not 3 <= strongest <= count:
            raise ParamsError(f"strongest must be a whole number from 3 to the {count} nodes, got {strongest!r}")
        order = np.argsort(ranges, axis=1, kind="stable")[:, :strongest]
        used_ranges, weights = np.take_along_axis(ranges, order, 1), np.take_along_axis(weights, order, 1)
        used_nodes = np.take_along_axis(nodes, order[..., None], 1)

    found = [_descend(used_nodes, used_ranges, weights, start) for start in _starts(used_nodes, used_ranges, prior)]
    position, mirror = _choose(used_nodes, used_ranges, weights, np.array(found), prior)
    directions, _ = _directions(used_nodes, position)
    covariance, condition, dilution = _precision(directions, weights)
    residual = ranges - np.linalg.norm(position[:, None] - nodes, axis=-1)
    out = Fix(position, covariance, residual, dilution, condition, mirror)
    return out if batched else Fix(**{name: value[0] for name, value in vars(out).items()})


def _to(name: str, value: Floats, shape: tuple[int, ...]) -> Floats:
    try:
        return np.broadcast_to(value, shape)
    except ValueError:
        raise ParamsError(f"{name} must fit the shape {shape} of the epochs, got {value.shape}") from None


def _directions(nodes: Floats, position: Floats) -> tuple[Floats, Floats]:
    """Unit vectors from the nodes (n, J, D) to the position (n, D), and the distances."""
    away = position[:, None] - nodes
    distance = np.maximum(np.linalg.norm(away, axis=-1), 1e-9)
    return away / distance[..., None], distance


def _misfit(nodes: Floats, ranges: Floats, weights: Floats, position: Floats) -> Floats:
    """Weighted sum of the squared residuals of (1)."""
    return np.sum(weights * (ranges - np.linalg.norm(position[:, None] - nodes, axis=-1)) ** 2, axis=1)


def _starts(nodes: Floats, ranges: Floats, prior: Floats | None) -> list[Floats]:
    """Closed-form positions to begin from, each (n, D).

    The differences of the squares of (1) are linear in the position. Along the direction in which the nodes are spread
    least they may say nothing; there the mean of the squares gives the distance but not the side: two beginnings.
    """
    middle = nodes.mean(axis=1, keepdims=True)
    away = nodes - middle
    _, spread, rows = np.linalg.svd(away, full_matrices=False)
    lost = np.flatnonzero(spread[:, -2] <= 1e-6 * (spread[:, 0] + ranges.mean(axis=1)))
    if lost.size:
        where = "at one point" if nodes.shape[-1] == 2 else "on one line"
        raise ParamsError(f"nodes_m must not all lie {where}, as they do at epoch {lost[0]}")
    square = np.sum(away * away, axis=-1) - ranges * ranges
    along = np.einsum("nij,nkj->nki", rows, away)  # nodes in the axes of their spread
    right = 0.5 * np.einsum("nki,nk->ni", along, square - square.mean(axis=1, keepdims=True))
    # Zero spread is a division by zero; the axis of least spread is replaced below where it matters.
    linear = right / np.maximum(spread * spread, 1e-12 * spread[:, :1] ** 2)
    flat = linear[:, :-1]
    height = np.sqrt(np.maximum(np.sum(-flat * flat, axis=1) - square.mean(axis=1), 0.01 * np.mean(ranges**2, axis=1)))
    starts = [np.column_stack([flat, height]), np.column_stack([flat, -height])]
    if nodes.shape[1] > nodes.shape[2]:
        reach = 10.0 * (ranges.max(axis=1, keepdims=True) + spread[:, :1])
        starts.append(np.clip(linear, -reach, reach))
        # More ranges than unknowns that do not fit together leave more minima: some of them lie to the sides.
        side = np.sqrt(np.mean(ranges**2, axis=1))[:, None]
        starts += [turn * side * np.eye(nodes.shape[-1])[k] for k in range(nodes.shape[-1]) for turn in (-1.0, 1.0)]
    out = [middle[:, 0] + np.einsum("ni,nij->nj", start, rows) for start in starts]
    return out if prior is None else [*out, prior]


def _descend(nodes: Floats, ranges: Floats, weights: Floats, position: Floats) -> Floats:
    """The minimum of the misfit below each beginning; epochs that have arrived are left out of the further steps."""
    found = position.copy()
    going = np.arange(len(position))
    damping = np.full(len(position), 1e-6)
    misfit = _misfit(nodes, ranges, weights, position)
    for _ in range(STEPS):
        step = _step(nodes, ranges, weights, position, damping)
        trial = position + step
        next_misfit = _misfit(nodes, ranges, weights, trial)
        better = next_misfit < misfit
        position = np.where(better[:, None], trial, position)
        misfit = np.where(better, next_misfit, misfit)
        damping = np.clip(np.where(better, 0.1 * damping, 10.0 * damping), 1e-15, 1e9)
        found[going] = position
        left = np.linalg.norm(step, axis=1) > 1e-13 * (1.0 + np.linalg.norm(position, axis=1))
        if not left.any():
            break
        if not left.all():
            nodes, ranges, weights, position = nodes[left], ranges[left], weights[left], position[left]
            damping, misfit, going = damping[left], misfit[left], going[left]
    return found


def _step(nodes: Floats, ranges: Floats, weights: Floats, position: Floats, damping: Floats) -> Floats:
    """(n, D): Newton's step, downhill also where the misfit curves downwards, as its curvatures enter by their size."""
    directions, distance = _directions(nodes, position)
    slope = np.einsum("nj,njd->nd", weights * (ranges - distance), directions)
    outer = directions[..., :, None] * directions[..., None, :]
    bend = (weights * (ranges / distance - 1.0))[..., None, None] * (np.eye(nodes.shape[-1]) - outer)
    curvature, axes = np.linalg.eigh(np.sum(weights[..., None, None] * outer - bend, axis=1))
    steepness = np.abs(curvature) + damping[:, None] * np.sum(weights, axis=1, keepdims=True)
    return np.einsum("ndi,ni->nd", axes, np.einsum("ndi,nd->ni", axes, slope) / steepness)


def _choose(
    nodes: Floats, ranges: Floats, weights: Floats, found: Floats, prior: Floats | None
) -> tuple[Floats, Floats]:
    """The position and its mirror among the minima (k, n, D)."""
    misfit = np.array([_misfit(nodes, ranges, weights, position) for position in found])
    every = np.arange(found.shape[1])
    scale = 1.0 + ranges.mean(axis=1)
    likely = misfit <= misfit.min(axis=0) + AMBIGUOUS
    if prior is None:
        even = misfit <= misfit.min(axis=0) * (1.0 + 1e-6) + 1e-12 * np.sum(weights, axis=1) * scale**2  # to rounding
        best = np.argmax(np.where(even, found[..., -1], -np.inf), axis=0)
    else:
        best = np.argmin(np.where(likely, np.linalg.norm(found - prior, axis=-1), np.inf), axis=0)
    position = found[best, every]
    # The other minimum, if one is likely and apart from the first by more than rounding.
    apart = np.linalg.norm(found - position, axis=-1) > 1e-5 * scale
    other = np.argmin(np.where(likely & apart, misfit, np.inf), axis=0)
    mirror = np.where((likely & apart).any(axis=0)[:, None], found[other, every], np.nan)
    return position, mirror


def _precision(directions: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """Covariance (H^T W H)^-1, condition number and dilution of the directions H (n, J, D).

    Without any hold on an axis they would be infinite; they are held at a condition number of 1e8.
    """

    def inverse(matrix: Floats) -> tuple[Floats, Floats]:
        value, axes = np.linalg.eigh(matrix)
        value = np.maximum(value, 1e-16 * value[:, -1:])
        return np.einsum("nij,nj,nkj->nik", axes, 1.0 / value, axes), np.sqrt(value[:, -1] / value[:, 0])

    covariance, _ = inverse(np.einsum("nji,nj,njk->nik", directions, weights, directions))
    alike, condition = inverse(np.einsum("nji,njk->nik", directions, directions))
    return covariance, condition, np.sqrt(np.trace(alike, axis1=1, axis2=2))
