"""How a step depends on the agent's own state and action: differences of the world's own kernels.

The agent's state x is its position, velocity and commanded way point: S = 6 numbers in the plane, 9 in space. The lanes
of a block fly the same step from slightly different x or actions; intruders and gusts are the same in all. What the
agent knows depends on x as well: its solution moves with it, and a track and its range move the other way. The errors
of solutions, ranges and tracks are held as they are.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from rss_gym.core import Batch
from rss_gym.jit import kernel
from rss_gym.lanes import load_aircraft
from rss_gym.observation import transform, write
from rss_gym.state import AIRCRAFT, AIRCRAFT_LANES, BLOCK, CONTACT_LANES, EPISODE, RANGES
from rss_gym.world import advance_clock, move_aircraft

DIFFERENCE = 0.05  # m, m/s, or share of the speed limit
PARTS = 3  # of the state: position, velocity, way point
EVENTS = ("snmac", "collision", "manoeuvre")
"""Each happens where a margin falls below a limit. The margin of an sNMAC is below its horizontal limit where both of
its limits are undercut: the greater of the horizontal distance and of the height, scaled by the ratio of the limits,
at the ticks. That of a collision is the distance itself, between the ticks too. That of a manoeuvre is minus the
distance from the predefined trajectory, at the ticks."""


class StepSensitivity(NamedTuple):
    """A step of n rows with S numbers of the state and A axes of the action; the inputs are (x, action) in this order.

    Attributes
    ----------
    state : (n, S) array
        After the step: position (m), velocity (m/s), commanded way point (m), world axes.
    state_slope : (n, S + A, S) array
        Derivative of the state after the step by each input.
    deviation_slope : (n, S + A) array
        The derivative of the distance from the predefined trajectory, summed over the ticks of the step, m.
    least_m : (n, 3) array
        Least margins in the step, from any intruder, m: by `EVENTS`.
    least_slope : (n, S + A, 3) array
        The derivatives of these margins.
    """

    state: np.ndarray
    state_slope: np.ndarray
    deviation_slope: np.ndarray
    least_m: np.ndarray
    least_slope: np.ndarray


class StepRecorder:
    """Remembers a batch before a step, and differentiates the step once it is flown.

    Parameters
    ----------
    batch : Batch
    """

    def __init__(self, batch: Batch) -> None:
        self.batch, self.axes = batch, 2 if batch.params.encounter.planar else 3
        aircraft = batch.state.aircraft.shape[1]
        self._scratch = (
            np.zeros(1, BLOCK),
            np.zeros(aircraft, AIRCRAFT_LANES),
            np.zeros(aircraft - 1, CONTACT_LANES),
            np.zeros(1, EPISODE),
            np.zeros(aircraft, AIRCRAFT),
        )
        self._before, self._ticks = batch.state.aircraft.copy(), batch.episode["tick"].copy()

    def remember(self) -> None:
        """To be called before `Batch.step`."""
        self._before[:] = self.batch.state.aircraft
        self._ticks[:] = self.batch.episode["tick"]

    def differentiate(self, actions: np.ndarray, rows: np.ndarray) -> StepSensitivity:
        """The step that has just been flown with `actions` (n, 3), in the rows of these numbers (m,)."""
        state, m = self.batch.state, len(rows)
        size, inputs = PARTS * self.axes, (PARTS + 1) * self.axes
        found = StepSensitivity(
            np.empty((m, size)),
            np.empty((m, inputs, size)),
            np.empty((m, inputs)),
            np.empty((m, len(EVENTS))),
            np.empty((m, inputs, len(EVENTS))),
        )
        _differentiate(
            state.config[0], *self._scratch, self._before, state.aircraft, state.episode, self._ticks, rows,
            actions, self.axes, found,
        )  # fmt: skip
        return found


def observation_sensitivity(batch: Batch, rows: np.ndarray) -> np.ndarray:
    """Derivative of the current observations of these rows by the agent's state, (m, S, d) float32."""
    state, seen = batch.state, batch.seen
    axes = 2 if batch.params.encounter.planar else 3
    slopes = np.empty((len(rows), PARTS * axes, batch.observations.shape[1]), np.float32)
    positions = state.config[0]["information"] != RANGES
    scratch = seen.own[:1].copy(), seen.others[0].copy(), state.tracks[0].copy()
    _observation_slopes(seen, state.tracks, *scratch, batch.observations, positions, axes, rows, slopes)
    return slopes


@kernel
def _differentiate(
    config, block, lanes, contacts, episode, aircraft, before, after, episodes, ticks, rows, actions, axes, found
):
    """Fly the step of each row once more on 1 + S + A lanes, the first as it was, and take differences to it."""
    size = PARTS * axes
    e, block_ = episode[0], block[0]
    stretch = config.snmac_horizontal_m / config.snmac_vertical_m
    least = np.empty((1 + size + axes, len(EVENTS)))
    for i in range(len(rows)):
        row = rows[i]
        present = 1 + episodes[row].intruders
        block_.rows = 1 + size + axes
        for a in range(present):
            aircraft[a] = before[row, a]
            for axis in range(3):  # the gusts of the step were drawn at its start
                aircraft[a].gust_mps[axis] = after[row, a].gust_mps[axis]
        for r in range(block_.rows):
            least[r] = inf
            block_.deviation_m[r] = block_.deviation_max_m[r] = block_.flown_m[r] = 0.0
            for a in range(present):
                load_aircraft(lanes[a], r, aircraft[a])
                lanes[a].clock_s[r] = ticks[row] * config.tick_s - aircraft[a].held_s
            for axis in range(3):
                block_.action[axis, r] = actions[row, axis]
        for axis in range(axes):
            lanes[0].position_m[axis, 1 + axis] += DIFFERENCE
            lanes[0].velocity_mps[axis, 1 + axes + axis] += DIFFERENCE
            lanes[0].way_point_m[axis, 1 + 2 * axes + axis] += DIFFERENCE
            block_.action[axis, 1 + size + axis] += inwards(actions[row, axis])
        for tick in range(ticks[row], episodes[row].tick):
            e.tick = tick + 1
            for r in range(block_.rows):
                block_.tick[r] = e.tick
                for a in range(present):
                    advance_clock(config, e, aircraft[a], lanes[a], r)
            move_aircraft(config, block_, lanes, contacts)
            for k in range(present - 1):
                p = contacts[k].relative_m
                for r in range(block_.rows):
                    level = sqrt(p[0, r] * p[0, r] + p[1, r] * p[1, r])
                    least[r, 0] = min(least[r, 0], max(level, stretch * abs(p[2, r])))
                    least[r, 1] = min(least[r, 1], contacts[k].least_m[r])
        for r in range(block_.rows):
            least[r, 2] = -block_.deviation_max_m[r]
        found.least_m[i] = least[0]
        for axis in range(axes):
            found.state[i, axis] = lanes[0].position_m[axis, 0]
            found.state[i, axes + axis] = lanes[0].velocity_mps[axis, 0]
            found.state[i, 2 * axes + axis] = lanes[0].way_point_m[axis, 0]
        for j in range(size + axes):
            r, step = 1 + j, DIFFERENCE if j < size else inwards(actions[row, j - size])
            found.deviation_slope[i, j] = (block_.deviation_m[r] - block_.deviation_m[0]) / step
            for event in range(len(EVENTS)):
                found.least_slope[i, j, event] = (least[r, event] - least[0, event]) / step
            for axis in range(axes):
                found.state_slope[i, j, axis] = (lanes[0].position_m[axis, r] - found.state[i, axis]) / step
                found.state_slope[i, j, axes + axis] = (
                    lanes[0].velocity_mps[axis, r] - found.state[i, axes + axis]
                ) / step
                found.state_slope[i, j, 2 * axes + axis] = (
                    lanes[0].way_point_m[axis, r] - found.state[i, 2 * axes + axis]
                ) / step


@kernel(inline="always")
def inwards(action):
    """The difference of an action in [-1, 1] that stays within these limits."""
    return DIFFERENCE if action < 0.5 else -DIFFERENCE


@kernel
def _observation_slopes(seen, tracks, own, others, tracks_, observations, positions, axes, rows, slopes):
    """Write each row's observation for a slightly different state, and take the difference to what it was."""
    planar = axes == 2
    for i in range(len(rows)):
        row = rows[i]
        for j in range(PARTS * axes):
            part, axis = j // axes, j % axes
            own[0] = seen.own[row]
            if part == 0:
                own[0].position_m[axis] += DIFFERENCE
            elif part == 1:
                own[0].velocity_mps[axis] += DIFFERENCE
            else:
                own[0].way_point_m[axis] += DIFFERENCE
            for k in range(len(others)):
                others[k], tracks_[k] = seen.others[row, k], tracks[row, k]
                if part < 2:
                    _displace(others[k], tracks_[k], part, axis)
            write(own[0], others, tracks_, planar, positions, seen.raw)
            out = slopes[i, j]
            transform(seen.raw, seen.table, out)
            for column in range(len(out)):
                out[column] = (out[column] - observations[row, column]) / np.float32(DIFFERENCE)


@kernel(inline="always")
def _displace(other, track, part, axis):
    """A track relative to an agent that is elsewhere (part 0) or flies otherwise (part 1), and its range."""
    p, v = track.position_m, track.velocity_mps
    level = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    along = p[axis] / level if track.valid and level > 1.0 else 0.0
    if part == 0:
        other.range_m -= DIFFERENCE * along
        p[axis] -= DIFFERENCE
        track.other_m[min(axis, 1)] -= DIFFERENCE if axis < 2 else 0.0
    else:
        other.range_rate_mps -= DIFFERENCE * along
        v[axis] -= DIFFERENCE
