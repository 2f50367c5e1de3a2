"""The range-only filter in the world: does it know how well it knows, and is a row a row of its own."""

import numpy as np
import pytest

from rss_gym import observation
from rss_gym.baselines.orthogonal import Orthogonal
from rss_gym.baselines.policy import Nothing
from rss_gym.baselines.range_only import ALONG, PROBABILITY, RIGHT, RangeOnly
from rss_gym.core import Batch, decode
from rss_gym.params import Params, ParamsError
from rss_gym.ranging import bank as banks

COUNT, DEGREES = 256, 360
AFTER_HOVER_S = 5.0


class Idle(Nothing):
    """A rule that never acts, so that both mirror images stay."""

    reads_positions = True


def located(rule, params=None):
    """The rule in the world `params`, on track `range`."""
    return RangeOnly(rule=rule, world=Params.of(params, track="range", **rule.interface()))


def flown(policy, count=COUNT, decisions=120):
    """Yield batch, live rows, observation, action and state of every decision; seeds from 7,000,000, split train."""
    batch = Batch(policy.world, count)
    batch.seed(np.arange(count, dtype=np.uint64) + np.uint64(7_000_000))
    batch.reset(np.ones(count, bool))
    state = None
    for step in range(decisions):
        seen = batch.observations.copy()
        actions, state = policy.predict(seen, state, np.full(count, step == 0))
        ended = batch.episode["terminated"] | batch.episode["truncated"]
        yield batch, ~ended, seen, actions, state
        batch.step(decode(actions, policy.world, count), ended)


def true_position(batch):
    """The intruder's true place along the leg and to the right of it, (n, 2)."""
    aircraft = batch.world.aircraft
    apart, along = aircraft["position_m"][:, 1] - aircraft["position_m"][:, 0], aircraft["along"][:, 0]
    return np.stack([(apart * along).sum(axis=1), apart[:, 0] * along[:, 1] - apart[:, 1] * along[:, 0]], axis=1)


def bearing_mass(bank, bearing_rad):
    """Probability of all bearings more probable than the true one: (rows,), uniform if the bank is right."""
    x, y, xx, xy, yy = (bank[..., column] for column in (banks.X, banks.Y, banks.XX, banks.XY, banks.YY))
    square = x * x + y * y
    std = np.sqrt(y * y * xx - 2.0 * x * y * xy + x * x * yy) / square
    grid = (np.arange(DEGREES) + 0.5) * 2.0 * np.pi / DEGREES
    off = (grid[:, None] - np.arctan2(y, x)[:, None] + np.pi) % (2.0 * np.pi) - np.pi
    density = (np.exp(bank[:, None, :, banks.WEIGHT] - 0.5 * (off / std[:, None]) ** 2) / std[:, None]).sum(axis=2)
    density /= density.sum(axis=1, keepdims=True)
    at = (bearing_rad % (2.0 * np.pi) * DEGREES / (2.0 * np.pi)).astype(int) % DEGREES
    here = density[np.arange(len(bank)), at]
    return np.where(density > here[:, None], density, 0.0).sum(axis=1)


@pytest.fixture(scope="module")
def flights():
    """Per decision under a warning: time since it opened, credible mass, NEES, error of the mean; the rule flies."""
    policy, opened, rows = located(Orthogonal(radius_m=60.0)), np.full(COUNT, np.inf), []
    for step, (batch, live, seen, _, state) in enumerate(flown(policy)):
        warned = observation.split(seen, policy.world)["warning"][:, 0] > 0.5
        now_s = step * policy.world.clock.decision_s
        opened = np.where(warned, np.minimum(opened, now_s), opened)
        rows_now = np.flatnonzero(warned & live)
        if step % 2 or not len(rows_now):
            continue
        heading, bank = policy.banks_of(state[rows_now])
        bank, (along, right) = bank[:, 0], true_position(batch)[rows_now].T
        hx, hy = heading.T
        truth = np.stack([hx * along - hy * right, hy * along + hx * right], axis=1)
        share = np.exp(bank[..., banks.WEIGHT])
        share /= share.sum(axis=1, keepdims=True)
        place = bank[..., [banks.X, banks.Y]]
        mean = (share[..., None] * place).sum(axis=1)
        off = place - mean[:, None]
        spread = bank[..., [banks.XX, banks.XY, banks.XY, banks.YY]].reshape(*share.shape, 2, 2)
        cov = (share[..., None, None] * (spread + off[..., :, None] * off[..., None, :])).sum(axis=1)
        error = mean - truth
        nees = (error * np.linalg.solve(cov, error[..., None])[..., 0]).sum(axis=1)
        mass = bearing_mass(bank, np.arctan2(truth[:, 1], truth[:, 0]))
        rows.append(np.stack([now_s - opened[rows_now], mass, nees, np.linalg.norm(error, axis=1)], axis=1))
    return np.concatenate(rows)


def test_the_true_bearing_is_in_the_90_percent_set(flights):
    """Decisions of a flight are not independent: the bounds are wider than those of so many coin tosses."""
    for low_s, high_s in ((AFTER_HOVER_S, 15.0), (15.0, 30.0), (30.0, 60.0)):
        mass = flights[(flights[:, 0] >= low_s) & (flights[:, 0] < high_s), 1]
        assert len(mass) > 1000
        assert 0.80 <= np.mean(mass < 0.9) <= 0.97
        assert 0.35 <= np.mean(mass < 0.5) <= 0.70


def test_the_squared_error_is_as_stated(flights):
    nees = flights[flights[:, 0] >= AFTER_HOVER_S, 2]
    assert 0.7 <= nees.mean() / 2.0 <= 1.3


def test_the_position_is_found_as_the_motion_changes(flights):
    first = np.median(flights[flights[:, 0] < 1.0, 3])
    last = np.median(flights[flights[:, 0] >= 30.0, 3])
    assert last < 0.5 * first and last < 16.0


def mirrored(observations, world):
    """The observation of the mirror image: everything to the right is to the left."""
    names = [f.name for f in observation.fields(world)]
    return observations * np.array([-1.0 if "_right_" in n or n == "turn_sin" else 1.0 for n in names], np.float32)


def test_mirror_symmetry():
    policy = located(Idle())
    one = two = None
    for _, _, seen, _, _ in flown(policy, 32, 80):
        one = np.zeros((32, policy.columns)) if one is None else one
        two = np.zeros_like(one) if two is None else two
        a = policy.sides(observation.split(seen, policy.world), one)[:, 0]
        b = policy.sides(observation.split(mirrored(seen, policy.world), policy.world), two)[:, 0, ::-1]
        np.testing.assert_allclose(b[..., PROBABILITY], a[..., PROBABILITY], atol=1e-6)
        likely = a[..., PROBABILITY] > 1e-6
        np.testing.assert_allclose(b[..., ALONG][likely], a[..., ALONG][likely], atol=1e-5)
        np.testing.assert_allclose(b[..., RIGHT][likely], -a[..., RIGHT][likely], atol=1e-5)
    assert np.isclose(a[..., PROBABILITY].sum(axis=-1), 1.0).sum() > 16


def test_the_first_message_leaves_both_mirror_images_as_probable():
    policy = located(Idle())
    first = np.full(64, -1.0)
    memory = None
    for _, _, seen, _, _ in flown(policy, 64, 60):
        memory = np.zeros((64, policy.columns)) if memory is None else memory
        sides = policy.sides(observation.split(seen, policy.world), memory)[:, 0, :, PROBABILITY]
        first = np.where((first < 0.0) & (sides.sum(axis=1) > 0.0), sides[:, 0], first)
    assert (first >= 0.0).sum() > 32
    np.testing.assert_allclose(first[first >= 0.0], 0.5, atol=1e-9)


@pytest.mark.parametrize("world", [{}, {"planar": False}, {"intruders": 3, "intruders_min": 1}])
def test_a_row_of_a_batch_equals_the_row_alone(world):
    policy = located(Orthogonal(radius_m=60.0), Params.of(**world))
    state, acted = None, False
    for step, (_, _, seen, actions, _) in enumerate(flown(policy, 4)):
        alone, state = policy.predict(seen[2], state, np.array([step == 0]))
        np.testing.assert_array_equal(alone, actions[2])
        assert np.isfinite(actions).all()
        acted |= bool(actions.any())
    assert acted


def test_memory_is_cleared_where_an_episode_starts():
    policy = located(Orthogonal(radius_m=60.0))
    *_, (_, _, seen, _, state) = flown(policy, 8, 80)
    fresh, _ = policy.predict(seen)
    mixed, _ = policy.predict(seen, state, np.arange(8) % 2 == 0)
    np.testing.assert_array_equal(mixed[::2], fresh[::2])
    assert np.any(mixed[1::2] != fresh[1::2])


def test_a_rule_without_use_for_positions_is_refused():
    with pytest.raises(ParamsError, match="Nothing reads no positions"):
        located(Nothing())
