"""Drives a policy over numbered episodes of a road and fills the world's episode table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from rss_gym.eval.episodes import Block, PolicyError, command
from rss_gym.eval.road.suites import RoadSuite
from rss_gym.eval.table import TABLE
from rss_gym.highway.env import RoadEnv
from rss_gym.physics.random import uniform
from rss_gym.streams import STREAM_SAMPLE

# What a road adds to the table: means over the decisions driven.
DEVIATIONS = np.dtype([("lane_deviation_m", np.float64), ("speed_deviation_mps", np.float64)])
COPIED = "channel zone min_separation_m closest_s warned_s false_alerts".split()


def environment(suite: RoadSuite, keywords: dict[str, Any]) -> RoadEnv:
    """The road of a suite, made as a policy needs it."""
    return RoadEnv(suite.scene, **{**suite.keywords, **keywords})


def drive(
    policy: Any, name: str, env: RoadEnv, block: Block, nominal: list[np.ndarray] | None = None
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Drive every episode of the block to its end.

    Parameters
    ----------
    policy : Policy
        Anything with SB3's `predict`, for one discrete action or what the road's action space holds.
    name : str
        For error sentences.
    env : RoadEnv
    block : Block
        Which episodes.
    nominal : list of (n, 2) arrays, optional
        Positions of the agent after each decision in the drives of `none`, one array an episode.

    Yields
    ------
    row, deviations : records of TABLE and DEVIATIONS, shape (1,)
    positions : (n, 2) array

    Raises
    ------
    PolicyError
        When the policy raises or returns what is not an action.
    """
    for index, episode in enumerate(block.numbers):
        yield _episode(policy, name, env, block, int(episode), None if nominal is None else nominal[index])


def _episode(
    policy: Any, name: str, env: RoadEnv, block: Block, episode: int, nominal: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    observation, _ = env.reset(seed=block.seed, options={"split": block.split, "episode": episode})
    sensor, clock = env.ranging.sensor, env.params.clock
    table, deviations = np.zeros(1, TABLE), np.zeros(1, DEVIATIONS)
    row = table[0]
    decisions = round(env.scene.duration_s / clock.decision_s)
    sampled = int(uniform(sensor.episode["key"], STREAM_SAMPLE, 0) * decisions)
    here, state, done = env.road.vehicle.position.copy(), None, False
    positions: list[np.ndarray] = []
    infos: list[dict[str, Any]] = []
    while not done:
        if len(infos) == sampled:
            row["sample_separation_m"], row["sample_range_m"] = _sample(sensor)
        actions, state = command(policy, name, observation[None], state, np.array([not infos]))
        try:
            action = np.asarray(actions)[0]
            observation, _, terminated, truncated, info = env.step(action)
        except (ValueError, TypeError, IndexError) as error:
            raise PolicyError(
                f"policy {name!r}: {' '.join(str(error).split())}; at decision {len(infos)} of episode {episode}"
            ) from error
        done = terminated or truncated
        infos.append(info)
        before, here = here, env.road.vehicle.position.copy()
        positions.append(here)
        row["flown_m"] += np.hypot(*(here - before))
        if nominal is not None and len(positions) <= len(nominal):
            row["manoeuvre_m"] = max(row["manoeuvre_m"], np.hypot(*(here - nominal[len(positions) - 1])))
    e = sensor.episode
    for column in COPIED:
        row[column] = e[column]
    row["episode"], row["missed_ticks"] = episode, e["missed"]
    row["collision"], row["snmac"] = info["collision"], info["snmac"]
    row["cost_m"], row["deviation_end_m"] = info["cost_m"], info["deviation_m"]
    row["flown_s"] = e["tick"] * clock.tick_s
    row["duration_s"] = max(env.scene.duration_s, row["flown_s"]) if info["collision"] else row["flown_s"]
    row["deviation_mean_m"] = info["deviation_mean_m"]
    row["deviation_max_m"] = max(item["deviation_m"] for item in infos)
    plan = env.ranging.plan
    assert plan is not None
    row["planned_m"] = plan.speed_mps * row["flown_s"]
    deviations["lane_deviation_m"] = np.mean([item["lane_error_m"] for item in infos])
    deviations["speed_deviation_mps"] = np.mean([item["speed_error_mps"] for item in infos])
    return table, deviations, np.array(positions)


def _sample(sensor: Any) -> tuple[float, float]:
    """True and estimated range of the nearest vehicle that is heard; zeros without one."""
    vehicles = sensor.vehicles
    gap = vehicles["position_m"][1:] - vehicles["position_m"][0]
    separation_m = np.where(vehicles["heard"][1:], np.hypot(gap[:, 0], gap[:, 1]), np.inf)
    if not np.isfinite(separation_m).any():
        return 0.0, 0.0
    nearest = int(np.argmin(separation_m))
    return float(separation_m[nearest]), float(sensor.range_m[nearest])
