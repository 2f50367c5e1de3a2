"""The package's own elementary functions and noise give the same bits in JavaScript, over random inputs."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from translated import run, shown

from rss_gym.baselines import network
from rss_gym.physics import elementary, geometry, random

COUNT = 400


def doubles(seed, low=-300.0, high=300.0):
    """Numbers of all sizes and signs, and the special ones."""
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(low, high, COUNT) * rng.choice([-1.0, 1.0], COUNT)
    near = rng.normal(0.0, 10.0, COUNT)
    special = [0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, 2.0**-1022, 1.0, -1.0, 709.7, 710.0, -745.2, 1e6, 22.0]
    return [*sizes.tolist(), *near.tolist(), *special]


@pytest.mark.parametrize("name", ["exp", "log", "log10", "sin", "cos", "tanh"])
def test_functions_of_one_number(name):
    function, values = getattr(elementary, name), doubles(len(name))
    assert run(function, *[(x,) for x in values]) == [shown(function(x)) for x in values]


def test_angle_of_a_point():
    ys, xs = doubles(1), doubles(2)
    assert run(elementary.atan2, *zip(ys, xs, strict=True)) == [
        shown(elementary.atan2(y, x)) for y, x in zip(ys, xs, strict=True)
    ]


def test_sigmoid_calls_translated_functions():
    values = doubles(7)
    assert run(network.sigmoid, *[(x,) for x in values]) == [shown(network.sigmoid(x)) for x in values]


def test_separation():
    rows = np.random.default_rng(3).normal(0.0, 30.0, (COUNT, 7)).tolist()
    assert run(geometry.least_square_separation, *map(tuple, rows)) == [
        shown(geometry.least_square_separation(*row)) for row in rows
    ]


def test_noise():
    rng = np.random.default_rng(5)
    keys = [np.uint64(key) for key in rng.integers(0, 2**64, COUNT, dtype=np.uint64)]
    calls = [(key, int(rng.integers(0, 700)), int(rng.integers(0, 10**6))) for key in keys]
    for function in (random.normal, random.uniform):
        assert run(function, *calls) == [shown(function(*call)) for call in calls]
    seeds = [(2, np.uint64(key), np.uint64(number)) for number, key in enumerate(keys)]
    assert run(random.episode_key, *seeds) == [str(int(random.episode_key(*seed))) for seed in seeds]
