"""The estimator, the tracker and the range decide who collides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import HEADER, ORCA, RULE, SEED, Scores, cheapest, danger, fly, row, value

ESTIMATORS = ("ekf-coloured", "ekf-white", "ekf-white-r", "ls")
TRACKS: dict[str, dict[str, Any]] = {
    "fused": {},
    "fused, range withheld": {"track_range": False},
    "latest": {"tracker": "latest"},
}


def ratio(one: float, other: float, count: int) -> str:
    """How many times as often; where the other never happened, by one event in all encounters."""
    return f"{one / other:.1f} times" if other > 0.0 else f"{one:.2e} against none in {count:,}"


def sections(scale: Scale) -> Iterator[Section]:
    """Estimators, then trackers, each with the rule and `orca` at their cheapest radius."""
    tuned = [cheapest(fly(names, scale, episodes=5000)) for names in (ORCA, RULE)]
    how = (
        f"Suite `encounter-v0`, {scale.episodes:,} encounters, seed {SEED}; each policy at the radius that was "
        "cheapest in 5,000."
    )
    by_estimator = {name: fly(tuned, scale, estimator=name) for name in ESTIMATORS}
    yield Section(
        "The estimator decides",
        how,
        HEADER,
        [row(policy, f"`{name}`", found[policy]) for policy in tuned for name, found in by_estimator.items()],
        list(_estimator_criteria(by_estimator, tuned[0], scale)),
    )
    by_track = {name: fly(tuned, scale, **changes) for name, changes in TRACKS.items()}
    yield Section(
        "The tracker and the range decide",
        how,
        HEADER,
        [row(policy, name, found[policy]) for policy in tuned for name, found in by_track.items()],
        [
            _less_danger(policy, other, by_track["fused"][policy], by_track[other][policy])
            for policy in tuned
            for other in ("latest", "fused, range withheld")
        ],
    )


def _estimator_criteria(found: dict[str, dict[str, Scores]], orca: str, scale: Scale) -> Iterator[Criterion]:
    best, ls, white_r = (found[name][orca] for name in ("ekf-coloured", "ls", "ekf-white-r"))
    collided, expected = value(ls, "collision_rate"), value(best, "collision_rate")
    yield Criterion(
        f"`{orca}`: collisions under `ls` at least 10 times those under `ekf-coloured`",
        ratio(collided, expected, scale.episodes),
        collided >= 10.0 * max(expected, 1.0 / scale.episodes),
    )
    yield Criterion(
        f"`{orca}`: collisions + sNMACs under `ekf-white-r` at least 2 times those under `ekf-coloured` (aim)",
        ratio(danger(white_r), danger(best), scale.episodes),
        danger(white_r) >= 2.0 * danger(best) > 0.0,
    )


def _less_danger(policy: str, other: str, fused: Scores, without: Scores) -> Criterion:
    flown = [value(scores, "path_deviation_mean_m") for scores in (fused, without)]
    return Criterion(
        f"`{policy}`: collisions + sNMACs with `fused` at most half of those with {other}, at equal or less deviation",
        f"{danger(fused):.2e} against {danger(without):.2e} at {flown[0]:.2f} and {flown[1]:.2f} m",
        danger(fused) <= 0.5 * danger(without) and flown[0] <= flown[1],
    )
