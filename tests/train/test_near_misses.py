"""The importance sampler of near misses: its weighted means are those of new encounters, and steadier."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from rss_gym.core import Batch
from rss_gym.params import Params
from rss_gym.train.pathwise.near_misses import NearMisses

LIMIT_M = 0.02


class Rows:
    """A batch whose encounters have a separation that is uniform on [0, 1] m and told by seed and number."""

    def __init__(self, n):
        self.n, self.seeds, self.numbers = n, np.arange(n, dtype=np.uint64), np.zeros(n, np.uint64)
        self.episode = np.zeros(n, [("seed", np.uint64), ("number", np.uint64)])

    def reset(self, mask):
        assert mask.all()
        self.episode["seed"], self.episode["number"] = self.seeds, self.numbers
        self.numbers += np.uint64(1)

    @property
    def least_m(self):
        return np.array([np.random.default_rng((int(s), int(k))).random() for s, k in self.episode])


def estimates(share, updates=400, n=64):
    """What each update says of the probability of a separation below half the limit."""
    rows, near, found = Rows(n), NearMisses(share, LIMIT_M, 128), []
    for update in range(updates):
        near.reset(rows, np.random.default_rng(update))
        least_m = rows.least_m
        weights = near.weigh(rows, least_m)
        found.append(np.mean(weights * (least_m < LIMIT_M / 2.0)))
    return np.array(found[updates // 4 :]), rows


def test_the_weighted_mean_is_that_of_new_encounters_with_less_variance():
    plain, rows = estimates(0.0)
    often, half = estimates(0.5)
    assert often.mean() == pytest.approx(LIMIT_M / 2.0, rel=0.15)
    assert often.std() < 0.35 * plain.std()
    assert np.all(rows.numbers == 400)
    # Rows that fly again go on with their own encounters afterwards, once there is enough to choose from.
    assert np.all(half.numbers[:32] == 400) and np.all(half.numbers[32:] < 100) and np.all(half.seeds == np.arange(64))


def test_the_weights_have_a_mean_of_one_though_flights_end_otherwise_each_time():
    rows, near, draws, means = Rows(64), NearMisses(0.5, 0.1, 128), np.random.default_rng(0), []
    for _ in range(200):
        near.reset(rows, draws)
        means.append(near.weigh(rows, draws.random(64)).mean())
    assert np.mean(means[50:]) == pytest.approx(1.0, abs=0.02)


def test_a_share_of_zero_flies_what_a_batch_flies_by_itself():
    params = Params.of()
    batches = Batch(params, 4), Batch(params, 4)
    for batch in batches:
        batch.seed(np.arange(4, dtype=np.uint64))
    near = NearMisses(0.0, 15.0, 16)
    for _ in range(3):
        near.reset(batches[0], np.random.default_rng(0))
        batches[1].reset(np.ones(4, bool))
        assert np.array_equal(batches[0].observations, batches[1].observations)
        assert np.array_equal(near.weigh(batches[0], np.zeros(4)), np.ones(4))


def test_an_encounter_that_flies_again_is_the_same_encounter():
    batch = Batch(Params.of(), 4)
    batch.seed(np.arange(4, dtype=np.uint64))
    near = NearMisses(0.5, 15.0, 2)
    near.reset(batch, np.random.default_rng(0))
    first = batch.observations.copy()
    near.weigh(batch, np.array([20.0, 10.0, 20.0, 10.0]))
    near.reset(batch, np.random.default_rng(0))
    again = batch.observations[2:]
    assert all(any(np.array_equal(row, known) for known in first[[1, 3]]) for row in again)
