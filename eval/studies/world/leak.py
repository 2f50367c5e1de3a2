"""No leak: what a message and an observation tell of the velocity and of the time of the closest approach."""

from __future__ import annotations

from typing import Any

import numpy as np

from rss_gym import observation
from rss_gym.eval.episodes import Block, start
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import SEED
from rss_gym.params import Params

EPISODES = 4000
TOLD = 0.94  # of the velocity error: what chance may take from it over these encounters
# What the state of the moment tells: the track and its approaches, the own flight, the range, the message's own state.
STATES = (
    "track_",
    "flown_",
    "planned_",
    "range_",
    "velocity_",
    "cruise",
    "offset_",
    "message_velocity",
    "message_position",
)
AXES = ("along", "right")
VECTORS = {
    "velocity": ["message_velocity_along_mps", "message_velocity_right_mps"],
    "position": ["message_position_along_m", "message_position_right_m"],
    "way point": ["message_way_point_along_m", "message_way_point_right_m"],
}


def section(scale: Scale) -> Section:
    """Least squares on one decision of each encounter: fitted on one half, errors of the other."""
    seen, left_s, velocity = sampled(Params.of(families="crossing"))
    error_mps = Params().navigation.velocity_mps
    fields = {**VECTORS, "way point and position": VECTORS["way point"] + VECTORS["position"]}
    fields["fields, all of them"] = [name for name in seen if name.startswith("message_")]
    rows, least = [], np.inf
    for title, names in fields.items():
        errors = [residual([seen[name] for name in names], velocity[:, axis]) for axis in range(2)]
        least = min(least, *errors)
        rows.append(
            [
                f"velocity of a straight intruder, along and to the right, from its message's {title}",
                *(f"{error:.3f} m/s" for error in errors),
            ]
        )
    seen, left_s, _ = sampled(Params())
    states = [seen[name] for name in seen if name.startswith(STATES)]
    times = residual(states, left_s), residual(list(seen.values()), left_s)
    rows.append(
        [
            "time to the planned closest approach, from the current state and from all fields",
            *(f"{time:.2f} s" for time in times),
        ]
    )
    return Section(
        "No leak",
        "Do the fields of an observation tell more than they should? Linear least squares estimates a quantity from "
        f"fields of one decision of each of {EPISODES:,} encounters, seed {SEED}; the table has the rms errors on "
        "the half that was not fitted. The tests do the same with boosted trees.",
        ("quantity and inputs", "first error", "second error"),
        rows,
        [
            Criterion(
                f"no message tells a velocity better than its error of {error_mps:g} m/s",
                f"{least:.3f} m/s",
                least > TOLD * error_mps,
            ),
            Criterion(
                "the whole observation tells the time of the planned closest approach no better than the current "
                "state (within 5 %)",
                f"{times[1]:.2f} s against {times[0]:.2f} s",
                times[1] > 0.95 * times[0],
            ),
        ],
    )


def residual(columns: list[np.ndarray], wanted: np.ndarray) -> float:
    """Rms error on the second half of the least squares that the first half gives."""
    design = np.column_stack([*columns, np.ones(len(wanted))])
    half = len(wanted) // 2
    fit = np.linalg.lstsq(design[:half], wanted[:half], rcond=None)[0]
    return float(np.sqrt(np.mean((wanted[half:] - design[half:] @ fit) ** 2)))


def sampled(params: Params) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """One decision of each encounter, drawn among those with a message, under wandering flight.

    Returns
    -------
    seen : dict of (n,) arrays
        The observation by name, SI.
    left_s : (n,) array
        Time left to the planned closest approach.
    velocity_mps : (n, 2) array
        The intruder's planned velocity along and to the right of the agent's leg.
    """
    batch: Any = start(params, Block("suite", SEED, range(EPISODES)))
    random, heard, ended = np.random.default_rng(0), np.zeros(EPISODES), np.zeros(EPISODES, bool)
    actions, rows = np.zeros((EPISODES, 3)), np.zeros_like(batch.observations)
    left_s, velocity = np.zeros(EPISODES), np.zeros((EPISODES, 2))
    while not ended.all():
        new = random.random(EPISODES) < 0.1
        actions[new, :2] = random.uniform(-0.3, 0.3, (int(new.sum()), 2))
        batch.step(actions, ~ended)
        ended |= batch.episode["terminated"] | batch.episode["truncated"]
        other, e = batch.seen.others[:, 0], batch.episode
        fresh = ~ended & other["valid"] & (other["age_s"] < params.clock.decision_s)
        heard += fresh
        take = fresh & (random.random(EPISODES) * heard < 1.0)
        rows[take], left_s[take] = batch.observations[take], (e["approach_s"] - params.clock.tick_s * e["tick"])[take]
        planned, along = batch.state.aircraft["planned_mps"][take, 1], batch.seen.own["along"][take]
        velocity[take, 0] = planned[:, 0] * along[:, 0] + planned[:, 1] * along[:, 1]
        velocity[take, 1] = planned[:, 0] * along[:, 1] - planned[:, 1] * along[:, 0]
    kept = heard > 0
    seen = observation.split(rows[kept], params)
    return {name: x if x.ndim == 1 else x[:, 0] for name, x in seen.items()}, left_s[kept], velocity[kept]
