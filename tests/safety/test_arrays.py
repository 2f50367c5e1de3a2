"""(29)-(40) as functions on arrays: the paper's figures, the world's kernels and parameters, NumPy and SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import norm

from rss_gym import safety
from rss_gym.params import ParamsError, Zone

PROBABILITIES = st.floats(0.01, 0.999)


@given(PROBABILITIES, st.floats(1e-12, 0.5), st.floats(0.01, 1000.0), st.floats(0.01, 60.0))
def test_agrees_with_the_parameters_of_the_world(probability, target, delta_m, reaction_s):
    zone = Zone(
        range_error_m=delta_m,
        range_error_probability=probability,
        collision_probability=target,
        speed_relative_max_mps=100.0,
        reaction_s=reaction_s,
        snmac_horizontal_m=0.1,
        snmac_vertical_m=0.1,
        collision_m=0.1,
    )
    assert safety.trials(probability, target) == zone.trials
    assert safety.radius_m(delta_m, probability, 100.0, reaction_s, zone.trials) == zone.radius_m


def test_radius_on_arrays_is_the_kernel():
    rng = np.random.default_rng(1)
    delta, probability, speed = rng.uniform(0.1, 20.0, (5, 1)), rng.uniform(0.5, 0.99, 7), rng.uniform(1.0, 20.0, 7)
    got = safety.radius_m(delta, probability, speed, 1.5, 8)
    assert got.shape == (5, 7)
    for i in range(5):
        for j in range(7):
            assert got[i, j] == safety.zone_radius_m(delta[i, 0], probability[j], speed[j], 1.5, 8.0)


def test_figures_of_the_paper():
    assert safety.perfect_radius_m(10.0, 1.0) == 10.0
    assert safety.trials(0.8, 1e-5) == 8
    assert safety.miss_probability(0.8, 8) == pytest.approx(2.56e-6, rel=1e-12)
    assert safety.radius_m([4.0, 16.0], 0.8, 10.0, 1.0, 8) == pytest.approx([120.0, 240.0])
    assert safety.pair_radius_m([120.0, 60.0], 80.0).tolist() == [80.0, 60.0]
    assert safety.violates(np.array([119.0, 120.0, 121.0]), 120.0).tolist() == [True, True, False]
    times_ms = 1e3 * safety.coherence_s([1.0, 2.0, 3.0], 2.5e9)
    assert [f"{t:.2f}" for t in times_ms] == ["25.39", "12.69", "8.46"]
    assert f"{1e3 * safety.coherence_s(1.0, 2.462e9):.2f}" == "25.78"
    # (39) prints 40; the whole part that (38) asks for is one less.
    assert safety.trials_max(25.39e-3) == 39
    assert safety.trials_max(0.025, 0.1) == 4
    assert safety.least_miss_probability(0.8, 25.39e-3) == pytest.approx(0.2**39)
    assert safety.least_miss_probability(0.8, 5.0) == pytest.approx(0.2)


@given(st.floats(0.1, 50.0), st.floats(0.0, 100.0))
def test_normal_error_is_the_integral_33(std_m, delta_m):
    integral = quad(lambda e: 2.0 * norm.pdf(e, scale=std_m), 0.0, delta_m, points=[min(std_m, delta_m)], limit=200)[0]
    assert safety.error_probability_normal(std_m, delta_m) == pytest.approx(integral, abs=1e-8)


def test_measured_error_probability_is_the_share():
    errors = [-3.0, 1.0, 4.0, -4.0, 10.0]
    assert safety.error_probability(errors, [0.5, 1.0, 4.0, 9.9, 10.0]).tolist() == [0.0, 0.2, 0.8, 0.8, 1.0]
    rng = np.random.default_rng(2)
    sample = rng.normal(0.0, 3.0, 100_000)
    assert safety.error_probability(sample, 4.0) == pytest.approx(safety.error_probability_normal(3.0, 4.0), abs=0.005)


def test_missed_detection_is_the_share_of_34():
    assert safety.missed_detection([100, 110, 130, 140], [130, 110, 125, 150], 120.0) == pytest.approx(1.0 / 3.0)
    assert np.isnan(safety.missed_detection([100.0], [90.0], 120.0))
    # Far from the edge few errors are large enough; the bound 1 - P(delta) of (34) holds.
    rng = np.random.default_rng(3)
    distance = rng.uniform(0.0, 400.0, 50_000)
    estimate = np.abs(distance + rng.normal(0.0, 4.0 / safety.STD_TO_80_PERCENT, distance.size))
    assert 0.0 < safety.missed_detection(distance, estimate, 120.0) < 0.2


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: safety.miss_probability(1.0, 8), "range_error_probability must be finite in .*, got 1"),
        (lambda: safety.trials(0.8, 0.0), "collision_probability must be finite in .*, got 0"),
        (lambda: safety.radius_m(4.0, 0.8, np.nan, 1.0, 8), "speed_relative_mps must be finite.*, got nan"),
        (lambda: safety.radius_m("4", 0.8, 1.0, 1.0, 8), "range_error_m must be a number.*'4'"),
        (lambda: safety.radius_m([[1.0], [1.0, 2.0]], 0.8, 1.0, 1.0, 8), "range_error_m must be a number"),
        (lambda: safety.coherence_s(0.0, 2.5e9), "speed_mps must be finite"),
        (lambda: safety.error_probability([], 4.0), "errors_m must hold at least one"),
    ],
)
def test_bad_input_is_one_sentence(call, words):
    with pytest.raises(ParamsError, match=words):
        call()
