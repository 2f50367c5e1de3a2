"""A control-barrier filter as a policy: round path following, or round any other policy."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from rss_gym.avoidance.approach import conflict
from rss_gym.avoidance.collision_cone import half_plane
from rss_gym.avoidance.half_planes import nearest
from rss_gym.baselines.intruders import Intruders
from rss_gym.baselines.velocity_rule import VelocityRule
from rss_gym.baselines.way_points import limited
from rss_gym.core import decode
from rss_gym.jit import kernel
from rss_gym.params import Params, ParamsError, number


@kernel
def _steer(flown, known, position, velocity, radius, lookahead_s, rate_ps, response_s, speed, out):
    """Filter the wanted velocities `out` (n, 3), m/s, of every row.

    `flown` (n, 3) is the own velocity, `known` (n, K) says who counts; `position`, `velocity` (n, K, 3) and `radius`
    (n, K) are in m and m/s.
    """
    intruders = known.shape[1]
    planes, room = np.zeros((intruders, 4)), np.zeros((intruders, 4))
    for row in range(len(out)):
        count = 0
        for k in range(intruders):
            if not known[row, k]:
                continue
            x, y, r = position[row, k, 0], position[row, k, 1], radius[row, k]
            ox, oy = velocity[row, k, 0], velocity[row, k, 1]
            if conflict(x, y, out[row, 0] - ox, out[row, 1] - oy, r, lookahead_s):
                vx, vy = flown[row, 0], flown[row, 1]
                half_plane(x, y, vx - ox, vy - oy, vx, vy, r, rate_ps, response_s, planes, count)
                count += 1
        if count:
            out[row, 0], out[row, 1] = nearest(planes, count, speed, out[row, 0], out[row, 1], room)


@dataclass(frozen=True, kw_only=True)
class Cbf(VelocityRule):
    """Collision-cone control-barrier filter (Thontepu et al. 2022), round path following or, as `cbf+NAME`, a policy.

    Parameters
    ----------
    radius_m, lookahead_s, sigmas
        See `VelocityRule`.
    rate_ps : float
        alpha of the barrier.
    response_s : float
        Time in which the autopilot takes up a commanded velocity.
    base : object, optional
        The policy that is filtered, with `predict` on the same observations; any kind of action.
    base_params : Params, optional
        The world of its actions, if it has no `params` of its own.

    Raises
    ------
    ParamsError
        For a base without `predict`, or without a world of its own or given.
    """

    rate_ps: float = number(0.5, 0.01, 10.0)
    response_s: float = number(1.0, 0.01, 10.0)
    base: Any = None
    base_params: Params | None = None

    def __post_init__(self) -> None:
        """Check that the policy to be filtered acts, and that it is known in what world."""
        super().__post_init__()
        if self.base is None:
            return
        if not callable(getattr(self.base, "predict", None)):
            raise ParamsError(f"base = {type(self.base).__name__} must have a method `predict`, as SB3's policies have")
        if not isinstance(self.base_params or getattr(self.base, "params", None), Params):
            raise ParamsError(
                f"base = {type(self.base).__name__} says nothing of its actions: give base_params, those it acts in"
            )

    def predict(
        self, observation_: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, Any]:
        """SB3's `predict`; round a policy the state is a pair, the filter's and the policy's."""
        if self.base is None:
            return super().predict(observation_, state, episode_start, deterministic)
        memory, inner = (None, None) if state is None else state
        actions, inner = self.base.predict(observation_, inner, episode_start, deterministic)
        act = functools.partial(self._filtered, actions=np.asarray(actions))
        actions, memory = self.answer(observation_, memory, episode_start, act)
        return actions, (memory, inner)

    def _filtered(self, seen: dict[str, np.ndarray], memory: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """Actions of `base` as velocities of the way point, filtered."""
        params = self.base_params or self.base.params
        limits = params.aircraft
        if actions.ndim < (1 if params.interface.action == "discrete" else 2):
            actions = actions[None]
        wanted = decode(actions, params, len(memory))
        wanted *= [limits.speed_max_mps, limits.speed_max_mps, limits.vertical_speed_max_mps]
        wanted[:, 0] += seen["cruise_mps"]
        return self.steered(seen, memory, limited(wanted, params))

    def steer(
        self,
        flown: np.ndarray,
        cruise_mps: np.ndarray,
        wanted: np.ndarray,
        others: Intruders,
        radius_m: np.ndarray,
        memory: np.ndarray,
    ) -> None:
        """The velocity nearest to `wanted` that every barrier allows."""
        _steer(
            flown,
            others.known,
            others.position_m,
            others.velocity_mps,
            radius_m,
            self.lookahead_s,
            self.rate_ps,
            self.response_s,
            self.params.aircraft.speed_max_mps,
            wanted,
        )
