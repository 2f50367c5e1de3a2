"""The derivative of a step, against the world itself flown from states that differ."""

import numpy as np
import pytest

from rss_gym.core import Batch
from rss_gym.params import Params
from rss_gym.sensitivity import StepRecorder, observation_sensitivity

WORLDS = {
    "plane": Params.of(),
    "space": Params.of(planar=False),
    "several": Params.of(families="merging", intruders=3, intruders_min=2),
    "turning": Params.of(families="turning"),
    "ranges": Params.of(information="ranges"),
}
ROWS = 32


def started(params, seed=3):
    batch = Batch(params, ROWS)
    batch.seed(np.arange(seed, seed + ROWS, dtype=np.uint64))
    batch.reset(np.ones(ROWS, bool))
    return batch


def actions_of(generator, params):
    actions = generator.uniform(-0.4, 0.4, (ROWS, 3))
    if params.encounter.planar:
        actions[:, 2] = 0.0
    return actions


def own_state(batch, axes):
    agent = batch.state.aircraft[:, 0]
    return np.concatenate([agent[name][:, :axes] for name in ("position_m", "velocity_mps", "way_point_m")], axis=1)


def agree(found, measured):
    """Up to a few rows in which a limit of the autopilot begins to bind between the two flights."""
    return np.sqrt(np.mean((found - measured) ** 2)) < 0.05 * np.sqrt(np.mean(measured**2))


@pytest.mark.slow
@pytest.mark.parametrize("name", WORLDS)
def test_the_first_lane_is_the_step_bit_for_bit(name):
    params, generator = WORLDS[name], np.random.default_rng(0)
    batch, rows = started(params), np.arange(ROWS)
    recorder, axes = StepRecorder(batch), 2 if params.encounter.planar else 3
    flying = np.ones(ROWS, bool)
    for _ in range(30):
        recorder.remember()
        actions = actions_of(generator, params)
        batch.step(actions, flying)
        found = recorder.differentiate(actions, rows[flying])
        np.testing.assert_array_equal(found.state, own_state(batch, axes)[flying])
        flying &= ~(batch.episode["terminated"] | batch.episode["truncated"])


@pytest.mark.parametrize("name", ["plane", "space", "several"])
def test_slopes_are_differences_of_whole_flights(name):
    """The world is flown twice from the reset, the second time with one action changed; later steps are chained."""
    params, axis, step, steps = WORLDS[name], 1, 0.01, 6
    plain, other = started(params), started(params)
    recorder, axes = StepRecorder(plain), 2 if params.encounter.planar else 3
    generator, everything, rows = np.random.default_rng(1), np.ones(ROWS, bool), np.arange(ROWS)
    chain = np.zeros((ROWS, 3 * axes))
    deviation = np.zeros(ROWS)
    for number in range(steps):
        actions = 0.1 * actions_of(generator, params)
        actions[:, 0] -= 0.2  # away from the limits, where a difference depends on its size
        recorder.remember()
        plain.step(actions, everything)
        found = recorder.differentiate(actions, rows)
        change = actions.copy()
        if number == 0:
            change[:, axis] += step
        other.step(change, everything)
        inputs = np.concatenate([chain, np.zeros((ROWS, axes))], axis=1)
        if number == 0:
            inputs[:, 3 * axes + axis] = 1.0
        deviation = np.einsum("ni,ni->n", inputs, found.deviation_slope)
        chain = np.einsum("ni,nij->nj", inputs, found.state_slope)
    measured = (own_state(other, axes) - own_state(plain, axes)) / step
    assert agree(chain, measured)
    ticks = params.clock.ticks_per_decision
    last = (other.episode["deviation_m"] - plain.episode["deviation_m"]) * ticks / step
    assert np.corrcoef(deviation, last)[0, 1] > 0.98  # |u - u^d| has a kink where it is zero


@pytest.mark.parametrize("name", ["plane", "space"])
def test_the_least_distance_is_that_of_the_episode(name):
    params = WORLDS[name]
    batch = started(params)
    recorder, flying, least = StepRecorder(batch), np.ones(ROWS, bool), np.full(ROWS, np.inf)
    while flying.any():
        rows = np.flatnonzero(flying)
        recorder.remember()
        batch.step(np.zeros((ROWS, 3)), flying)
        least[rows] = np.minimum(least[rows], recorder.differentiate(np.zeros((ROWS, 3)), rows).least_m[:, 1])
        flying &= ~(batch.episode["terminated"] | batch.episode["truncated"])
    np.testing.assert_array_equal(least, batch.episode["min_separation_m"])


@pytest.mark.parametrize("name", WORLDS)
def test_the_observation_moves_with_the_agent_and_the_track_against_it(name):
    from rss_gym import observation

    params = WORLDS[name]
    batch, axes = started(params), 2 if params.encounter.planar else 3
    for _ in range(20):
        batch.step(np.zeros((ROWS, 3)), np.ones(ROWS, bool))
    slopes = observation_sensitivity(batch, np.arange(ROWS))
    names = [field.name for field in observation.fields(params)]
    scale = {field.name: field.stretch or field.scale for field in observation.fields(params)}
    along = batch.seen.own["along"]
    right = np.stack([along[:, 1], -along[:, 0]], axis=1)
    column = names.index("velocity_right_mps")
    slope = slopes[:, axes : axes + 2, column] * scale["velocity_right_mps"]
    np.testing.assert_allclose(slope, right, atol=2e-3)
    column = names.index("intruder_0.track_position_along_m")
    tracked = batch.state.tracks["valid"][:, 0]
    assert tracked.any()
    slope = slopes[tracked, :2, column] * scale["intruder_0.track_position_along_m"]
    np.testing.assert_allclose(slope, -along[tracked, :2], atol=2e-3)
