"""Rules that need a position, flown on track `range`: a bank of bearings stands in for the positions not exchanged."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rss_gym.baselines.orthogonal import Orthogonal, vectors
from rss_gym.baselines.policy import Scripted
from rss_gym.jit import kernel
from rss_gym.params import Params, ParamsError, number
from rss_gym.physics.noise import decay
from rss_gym.ranging import bank as banks
from rss_gym.ranging.bearing import held_dbm, held_variance_db2

HYPOTHESES = 36
# Of a row: the heading of the leg in the axes of the first one, and the turn to come.
HEADING_X, HEADING_Y, TURN_S, TURN_COS, TURN_SIN, ROW = range(6)
# Of an intruder, before its bank: open, relative velocity at the last decision, the other's velocity before its hover.
OPEN, VX, VY, BEFORE_X, BEFORE_Y, HOVER_S, CONTACT = range(7)


@kernel
def _track(turn, own_mps, heard, valid, range_m, std_m, coloured_db, told_mps, age_s, channel, models, world, memory, out):
    """Advance every bank by a decision; `out` (n, K, 3, 6) are the sums by side: all, left, right, in the leg's axes."""
    decision_s, hover_s, unheard_m2 = world
    for row in range(len(memory)):
        m = memory[row]
        if m[HEADING_X] == 0.0 and m[HEADING_Y] == 0.0:
            m[HEADING_X] = 1.0
        elif turn[row, 0] > m[TURN_S]:  # the time to the turn grows only where it has been made
            x, y = m[HEADING_X], m[HEADING_Y]
            m[HEADING_X], m[HEADING_Y] = x * m[TURN_COS] - y * m[TURN_SIN], x * m[TURN_SIN] + y * m[TURN_COS]
        m[TURN_S], m[TURN_COS], m[TURN_SIN] = turn[row, 0], turn[row, 1], turn[row, 2]
        hx, hy = m[HEADING_X], m[HEADING_Y]
        width = CONTACT + HYPOTHESES * banks.COLUMNS
        for k in range(range_m.shape[1]):
            c = m[ROW + k * width : ROW + (k + 1) * width]
            if not valid[row, k]:
                c[:] = 0.0
                continue
            model = models[channel[row, k]]
            bank = c[CONTACT:].reshape(-1, banks.COLUMNS)
            ox, oy = told_mps[row, k, 0], told_mps[row, k, 1]
            ox, oy = hx * ox - hy * oy, hy * ox + hx * oy
            ux, uy = own_mps[row, 0], own_mps[row, 1]
            ux, uy = hx * ux - hy * uy, hy * ux + hx * uy
            if c[OPEN] == 0.0:
                c[OPEN], c[BEFORE_X], c[BEFORE_Y] = 1.0, ox, oy
                banks.start(bank, range_m[row, k], std_m[row, k], coloured_db[row, k], ox - ux, oy - uy, model)
            else:
                c[HOVER_S] += decision_s
                dx, dy = 0.5 * decision_s * (c[VX] + ox - ux), 0.5 * decision_s * (c[VY] + oy - uy)
                spread = model.spread_m2 + (0.0 if heard[row, k] else unheard_m2)
                banks.advance(bank, dx, dy, spread, range_m[row, k], coloured_db[row, k], model)
            c[VX], c[VY] = ox - ux, oy - uy
            # While the other hovers, sides are those of the motion it will resume.
            vx, vy = c[VX], c[VY]
            if c[HOVER_S] < hover_s:
                vx, vy = c[BEFORE_X] - ux, c[BEFORE_Y] - uy
            for n in range(3):
                w, x, y, xx, xy, yy = banks.side(bank, vx, vy, (0.0, -1.0, 1.0)[n])
                o = out[row, k, n]
                o[0], o[1], o[2] = w, hx * x + hy * y, hx * y - hy * x
                o[3] = hx * hx * xx + 2.0 * hx * hy * xy + hy * hy * yy
                o[4] = (hx * hx - hy * hy) * xy + hx * hy * (yy - xx)
                o[5] = hx * hx * yy - 2.0 * hx * hy * xy + hy * hy * xx


@dataclass(frozen=True, kw_only=True)
class Located(Scripted):
    """A rule that reads positions, flown on track `range`."""

    rule: Scripted = field(default_factory=Orthogonal)
    rest_inflation: float = number(1.5, 0.1, 100.0)
    horizon_s: float = number(40.0, 0.0, 1000.0)
    closing_std_mps: float = number(0.5, 1e-3, 100.0)
    unheard_mps: float = number(1.0, 0.0, 10.0)
    mode: float = number(0.0, 0.0, 3.0)
    future: float = number(0.0, 0.0, 3.0)

    def interface(self) -> dict[str, Any]:
        return self.rule.interface() | {"track": "range"}

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "rule", dataclasses.replace(self.rule, world=self.world))

    @property
    def columns(self) -> int:
        return self.rule.columns + ROW + self.world.encounter.intruders * (CONTACT + HYPOTHESES * banks.COLUMNS)

    def models(self) -> np.ndarray:
        clock, nav = self.world.clock, self.world.navigation
        out = np.zeros(len(self.world.channels), banks.MODEL)
        std = {"dead-reckoning": nav.dead_reckoning_mps}
        v2 = sum(std.get(s, nav.velocity_mps) ** 2 for s in (nav.agent, nav.intruder))
        for model, channel in zip(out, self.world.channels, strict=True):
            a = decay(clock.tick_s, channel.coloured_tc_s)
            model["path_loss_factor"] = channel.path_loss_factor
            model["factor_decay"] = decay(clock.decision_s, channel.path_loss_wander_tc_s)
            model["factor_variance"] = channel.path_loss_wander**2
            model["coloured_decay"] = decay(clock.decision_s, channel.coloured_tc_s)
            model["coloured_variance_db2"] = channel.coloured_variance_db2
            model["drive_db2"] = channel.coloured_variance_db2 * (1 - a * a)
            model["white_variance_db2"] = channel.white_variance_db2
            model["process_noise_m2"] = self.world.ranging.process_noise_m2
        out["rest_inflation"] = self.rest_inflation
        out["vertical_variance_m2"] = 0.0 if self.world.encounter.planar else self.world.encounter.vertical_offset_m**2
        out["spread_m2"] = v2 * self.horizon_s * clock.decision_s
        out["closing_std_mps"] = self.closing_std_mps
        out["floor_m"] = 1.0
        return out

    def track(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        factors = np.array([c.path_loss_factor for c in self.world.channels])
        channel = np.abs(seen["path_loss_factor"][..., None] - factors).argmin(axis=-1)
        out = np.zeros((*seen["range_m"].shape, 3, 6))
        valid = seen["message_valid"] > 0.5
        _track(
            np.stack([seen["turn_in_s"], seen["turn_cos"], seen["turn_sin"]], axis=-1),
            vectors(seen, "velocity", "mps"),
            (seen["warning"] > 0.5) & valid,
            valid,
            np.ascontiguousarray(seen["range_m"]),
            np.ascontiguousarray(seen["range_std_m"]),
            np.ascontiguousarray(seen["coloured_db"]),
            vectors(seen, "message_velocity", "mps"),
            np.ascontiguousarray(seen["message_age_s"]),
            channel,
            self.models(),
            (self.world.clock.decision_s, self.world.zone.hover_s, self.unheard_mps**2 * self.horizon_s * self.world.clock.decision_s),
            memory,
            out,
        )
        return out

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        sums = self.track(seen, memory)
        if self.mode == 0:
            best = sums[..., 0, :]
        else:
            side = 1 + (sums[..., 2, 0] > sums[..., 1, 0])
            best = np.take_along_axis(sums, side[..., None, None], axis=2)[..., 0, :]
        seen = dict(seen)
        seen["message_position_along_m"], seen["message_position_right_m"] = best[..., 1].copy(), best[..., 2].copy()
        f = self.columns - self.rule.columns
        own = memory[:, f:].copy()
        if self.future:
            m = memory[:, :f]
            hx, hy = m[:, HEADING_X, None], m[:, HEADING_Y, None]
            c = m[:, ROW:].reshape(len(m), self.world.encounter.intruders, -1)
            w = (c[..., OPEN] > 0) & (c[..., HOVER_S] < self.world.zone.hover_s)
            x, y = c[..., BEFORE_X], c[..., BEFORE_Y]
            seen["message_velocity_along_mps"] = np.where(w, hx * x + hy * y, seen["message_velocity_along_mps"])
            seen["message_velocity_right_mps"] = np.where(w, hx * y - hy * x, seen["message_velocity_right_mps"])
        out = self.rule.act(seen, own)
        memory[:, f:] = own
        return out
