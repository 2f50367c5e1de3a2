"""Rules that need a position, flown on track `range`: banks of bearings stand in for the positions not exchanged.

A bank opens with the first message of a warning and lives until the episode ends. It holds both mirror images of the
other; what the agent flies tells them apart, as its turns and displacements change the relative velocity.

An outage is not told apart from reception: the range that the link's filter holds in silence counts as measured. On
family `outage` the mean NEES of the position is 1.4 in the silence and 2.4 after it, where 2 is right (`orthogonal`,
256 training encounters, seeds from 7,000,000). Banks that only moved in the silence had 1.1 and 1.9, and no fewer
collisions: of 600 encounters (`suite`, seed 3) 22, 8 and 21 with `orthogonal`, `orca` and
`mvp:radius_m=30,lookahead_s=40`, against 15, 5 and 19.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rss_gym.baselines.located import vectors
from rss_gym.baselines.orthogonal import Orthogonal
from rss_gym.baselines.policy import Scripted
from rss_gym.jit import kernel
from rss_gym.params import ParamsError, number
from rss_gym.physics.noise import decay
from rss_gym.ranging import bank as banks

HYPOTHESES = 36
FLOOR_M = 1.0  # nearer, the slope of the path loss would say more about the bearing than the motion can
CLOSING_STD_MPS = 0.5  # the message may already tell the first half second of braking
DRIFT_S = 40.0  # a velocity's error persists: over this time it drifts as far as the random walk that stands for it
UNHEARD_MPS = 1.0  # error of a velocity that is no longer told
# Columns of a row: heading of the leg in the axes of the first leg, and the turn to come.
HEADING_X, HEADING_Y, TURN_S, TURN_COS, TURN_SIN, ROW = range(6)
# Columns of an intruder, before those of its bank: open, and the relative velocity at the last decision.
OPEN, VX, VY, CONTACT = range(4)
WIDTH = CONTACT + HYPOTHESES * banks.COLUMNS
# Of a side: its probability, the position along and to the right, and the covariance of that.
PROBABILITY, ALONG, RIGHT, ALONG_ALONG, ALONG_RIGHT, RIGHT_RIGHT = range(6)


@kernel
def _locate(
    turn, own_mps, heard, valid, range_m, std_m, coloured_db, told_mps, model_of, models, decision_s, memory, out
):
    """Advance every bank by a decision and sum it up: `out` (n, K, 2, 6), to the left and right of relative motion."""
    for row in range(len(memory)):
        m = memory[row]
        if m[HEADING_X] == 0.0 and m[HEADING_Y] == 0.0:
            m[HEADING_X] = 1.0
        elif turn[row, 0] > m[TURN_S]:  # the time to the next turn grows only when one has been made
            x, y = m[HEADING_X], m[HEADING_Y]
            m[HEADING_X], m[HEADING_Y] = x * m[TURN_COS] - y * m[TURN_SIN], x * m[TURN_SIN] + y * m[TURN_COS]
        m[TURN_S], m[TURN_COS], m[TURN_SIN] = turn[row, 0], turn[row, 1], turn[row, 2]
        hx, hy = m[HEADING_X], m[HEADING_Y]
        for k in range(range_m.shape[1]):
            c = m[ROW + k * WIDTH : ROW + (k + 1) * WIDTH]
            if not valid[row, k]:
                c[:] = 0.0
                continue
            model, bank = models[model_of[row, k]], c[CONTACT:].reshape(-1, banks.COLUMNS)
            along, right = told_mps[row, k, 0] - own_mps[row, 0], told_mps[row, k, 1] - own_mps[row, 1]
            vx, vy = hx * along - hy * right, hy * along + hx * right
            if c[OPEN] == 0.0:
                c[OPEN] = 1.0
                banks.start(bank, range_m[row, k], std_m[row, k], coloured_db[row, k], vx, vy, model)
            else:
                dx, dy = 0.5 * decision_s * (c[VX] + vx), 0.5 * decision_s * (c[VY] + vy)
                spread_m2 = model.spread_m2 if heard[row, k] else model.spread_unheard_m2
                banks.advance(bank, dx, dy, spread_m2, range_m[row, k], coloured_db[row, k], model)
            c[VX], c[VY] = vx, vy
            for n in range(2):
                w, x, y, xx, xy, yy = banks.side(bank, vx, vy, 2.0 * n - 1.0)
                o = out[row, k, n]
                o[PROBABILITY], o[ALONG], o[RIGHT] = w, hx * x + hy * y, hx * y - hy * x
                o[ALONG_ALONG] = hx * hx * xx + 2.0 * hx * hy * xy + hy * hy * yy
                o[ALONG_RIGHT] = (hx * hx - hy * hy) * xy + hx * hy * (yy - xx)
                o[RIGHT_RIGHT] = hx * hx * yy - 2.0 * hx * hy * xy + hy * hy * xx
            total = out[row, k, 0, PROBABILITY] + out[row, k, 1, PROBABILITY]
            out[row, k, 0, PROBABILITY] /= total
            out[row, k, 1, PROBABILITY] /= total


@dataclass(frozen=True, kw_only=True)
class RangeOnly(Scripted):
    """A rule that reads exchanged positions, flown on track `range` on where the other most probably is.

    Parameters
    ----------
    rule : Scripted
        One that reads positions, commanding whatever kind of action. It is handed, as `message_position` of age zero,
        the mean of the more probable side of the bank, in the plane, with `message_position_std_m`, per axis.
    miss_std_m : float
        Prior of the distance at which the other passes if nobody acts; 42 m on 4,000 training encounters, all families.
    rest_inflation : float
        Factor on the variance of what the link's filter holds beside the coloured noise. At 3 the 90 % credible set of
        the bearing holds the true one in 90-92 % of the decisions after the hover (256 training encounters, channel
        `paper`, seeds from 7,000,000); on channel `quadcopter` in 83-84 %.

    Raises
    ------
    ParamsError
        If the rule reads no positions.
    """

    rule: Scripted = field(default_factory=Orthogonal)
    miss_std_m: float = number(42.0, 1.0, 1e6)
    rest_inflation: float = number(3.0, 0.1, 100.0)

    tracks = ("range",)

    def interface(self) -> dict[str, Any]:
        """As the rule."""
        return self.rule.interface()

    def __post_init__(self) -> None:
        """The rule flies in the same world; its memory follows that of the banks."""
        super().__post_init__()
        if not self.rule.reads_positions:
            raise ParamsError(f"rule {type(self.rule).__name__} reads no positions, so it needs no range-only filter")
        object.__setattr__(self, "rule", dataclasses.replace(self.rule, world=self.world))
        object.__setattr__(self, "columns", self._first + self.rule.columns)

    @property
    def _first(self) -> int:
        """Where the rule's memory begins."""
        return ROW + self.world.encounter.intruders * WIDTH

    def models(self) -> np.ndarray:
        """What a bank knows of each channel of the world, records `ranging.bank.MODEL`.

        An observation tells channels apart by their path loss factors; of two with one factor the first is taken.
        """
        world, clock, nav = self.world, self.world.clock, self.world.navigation
        out = np.zeros(len(world.channels), banks.MODEL)
        for model, channel in zip(out, world.channels, strict=True):
            tick_decay = decay(clock.tick_s, channel.coloured_tc_s)
            model["path_loss_factor"] = channel.path_loss_factor
            model["factor_decay"] = decay(clock.decision_s, channel.path_loss_wander_tc_s)
            model["factor_variance"] = channel.path_loss_wander**2
            model["coloured_decay"] = decay(clock.decision_s, channel.coloured_tc_s)
            model["coloured_variance_db2"] = channel.coloured_variance_db2
            model["drive_db2"] = channel.coloured_variance_db2 * (1.0 - tick_decay**2)
            model["white_variance_db2"] = channel.white_variance_db2 + channel.quantisation_db**2 / 12.0
        errors = {"dead-reckoning": nav.dead_reckoning_mps, "gnss": nav.velocity_mps}
        variance = sum(errors[side] ** 2 for side in (nav.agent, nav.intruder))
        out["process_noise_m2"], out["rest_inflation"] = world.ranging.process_noise_m2, self.rest_inflation
        out["vertical_variance_m2"] = 0.0 if world.encounter.planar else world.encounter.vertical_offset_m**2
        out["spread_m2"] = variance * DRIFT_S * clock.decision_s
        out["spread_unheard_m2"] = (variance + UNHEARD_MPS**2) * DRIFT_S * clock.decision_s
        out["closing_std_mps"], out["miss_std_m"], out["floor_m"] = CLOSING_STD_MPS, self.miss_std_m, FLOOR_M
        return out

    def sides(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """Advance the banks in `memory` (n, columns) by the decision `seen`.

        Returns
        -------
        (n, K, 2, 6) array
            Left and right of the relative velocity: probability, mean position along and to the right (m), and its
            covariance (along-along, along-right, right-right; m^2). Zero where no message was ever received.
        """
        factors = np.array([channel.path_loss_factor for channel in self.world.channels])
        valid = seen["message_valid"] > 0.5
        out = np.zeros((*valid.shape, 2, 6))
        _locate(
            np.stack([seen["turn_in_s"], seen["turn_cos"], seen["turn_sin"]], axis=-1),
            vectors(seen, "velocity", "mps"),
            seen["warning"] > 0.5,
            valid,
            np.ascontiguousarray(seen["range_m"]),
            np.ascontiguousarray(seen["range_std_m"]),
            np.ascontiguousarray(seen["coloured_db"]),
            vectors(seen, "message_velocity", "mps"),
            np.abs(seen["path_loss_factor"][..., None] - factors).argmin(axis=-1),
            self.models(),
            self.world.clock.decision_s,
            memory,
            out,
        )
        return out

    @staticmethod
    def probable(sides: np.ndarray) -> np.ndarray:
        """The more probable side of each intruder, (n, K, 6), of what `sides` returns."""
        chosen = sides[..., PROBABILITY].argmax(axis=-1)
        return np.take_along_axis(sides, chosen[..., None, None], axis=-2)[..., 0, :]

    @staticmethod
    def placed(seen: dict[str, np.ndarray], side: np.ndarray) -> dict[str, np.ndarray]:
        """What is seen, with positions as if a message told them now; `side` as of `probable`."""
        return seen | {
            "message_age_s": np.zeros_like(seen["message_age_s"]),  # the banks fly on to now
            "message_position_along_m": side[..., ALONG],
            "message_position_right_m": side[..., RIGHT],
            "message_position_std_m": np.sqrt(0.5 * (side[..., ALONG_ALONG] + side[..., RIGHT_RIGHT])),
        }

    def banks_of(self, memory: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heading of the leg (n, 2) and the banks (n, K, hypotheses, columns), in the axes of the first leg."""
        contacts = memory[:, ROW : self._first].reshape(len(memory), -1, WIDTH)
        bank = contacts[..., CONTACT:].reshape(*contacts.shape[:2], HYPOTHESES, banks.COLUMNS)
        return memory[:, [HEADING_X, HEADING_Y]], bank

    def act(self, seen: dict[str, np.ndarray], memory: np.ndarray) -> np.ndarray:
        """The rule's action on the more probable side."""
        placed = self.placed(seen, self.probable(self.sides(seen, memory)))
        rule_memory = memory[:, self._first :].copy()
        actions = self.rule.act(placed, rule_memory)
        memory[:, self._first :] = rule_memory
        return actions
