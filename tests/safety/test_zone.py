"""The safety zone against the paper's worked examples and the formulas (29)-(40)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from rss_gym.params import Params, Zone
from rss_gym.safety import STD_TO_80_PERCENT, violates, zone_radius_m

DELTAS_M = st.floats(0.01, 100.0)
PROBABILITIES = st.floats(0.01, 0.999)
SPEEDS_MPS = st.floats(0.0, 50.0)
TIMES_S = st.floats(0.01, 10.0)
TRIALS = st.integers(1, 50)


def test_example_under_40():
    """delta 4 m, P 0.8, v 10 m/s, t_r 1 s, n_d 8: S = 120 m; twice delta, speed and time give the 240 m of Fig. 12."""
    assert zone_radius_m(4.0, 0.8, 10.0, 1.0, 8) == pytest.approx(120.0, rel=1e-15)
    assert Zone().radius_m == pytest.approx(120.0, rel=1e-15)
    assert Params().zone.radius_m == Zone().radius_m


def test_example_of_twice_the_radius():
    assert zone_radius_m(8.0, 0.8, 10.0, 2.0, 8) == pytest.approx(240.0, rel=1e-15)
    assert zone_radius_m(8.0, 0.8, 20.0, 1.0, 8) == pytest.approx(240.0, rel=1e-15)
    assert zone_radius_m(4.0, 0.8, 10.0, 1.0, 16) == pytest.approx(240.0, rel=1e-15)


def test_example_under_37():
    """P(4 m) = 80 %, collision probability 1e-5: n_d = 8; 0.2^8 = 2.56e-6 meets (36), 0.2^7 does not."""
    zone = Zone()
    assert zone.trials == 8
    assert 0.2**8 < zone.collision_probability < 0.2**7


@given(PROBABILITIES, st.floats(1e-12, 0.5))
def test_trials_are_the_fewest_that_satisfy_36(probability, collision_probability):
    trials = Zone(
        speed_relative_max_mps=100.0, range_error_probability=probability, collision_probability=collision_probability
    ).trials
    # A power that equals the target to rounding may be counted either way.
    assert (1.0 - probability) ** trials <= collision_probability * (1.0 + 1e-9)
    assert trials == 1 or (1.0 - probability) ** (trials - 1) > collision_probability * (1.0 - 1e-9)


@pytest.mark.parametrize(("probability", "exponent"), [(0.9, 1), (0.9, 5), (0.9, 9), (0.5, 3), (0.99, 2)])
def test_trials_at_exact_powers(probability, exponent):
    zone = Zone(
        speed_relative_max_mps=100.0,
        range_error_probability=probability,
        collision_probability=min(0.5, (1.0 - probability) ** exponent),
    )
    assert zone.trials == exponent


@given(DELTAS_M, PROBABILITIES, SPEEDS_MPS, TIMES_S, TRIALS)
def test_radius_is_40(delta, probability, speed, reaction, trials):
    radius = zone_radius_m(delta, probability, speed, reaction, trials)
    assert radius == pytest.approx(trials * delta / probability + trials * speed * reaction, rel=1e-12)
    # Worse ranging, more speed and a slower reaction each ask for more room; it is never below perfect ranging (30).
    assert radius >= trials * speed * reaction
    assert zone_radius_m(2.0 * delta, probability, speed, reaction, trials) > radius
    assert zone_radius_m(delta, probability, speed + 1.0, reaction, trials) > radius
    assert zone_radius_m(delta, probability, speed, 2.0 * reaction, trials) >= radius


def test_adaptive_delta_is_the_80_percent_point_of_a_normal_error():
    assert pytest.approx(norm.ppf(0.9), rel=1e-15) == STD_TO_80_PERCENT
    assert norm.cdf(STD_TO_80_PERCENT) - norm.cdf(-STD_TO_80_PERCENT) == pytest.approx(0.8, abs=1e-12)


def test_adaptive_radius_reaches_the_fixed_one_at_the_papers_accuracy():
    """A filter whose std makes 80 % of errors less than 4 m, at 10 m/s, has the paper's zone."""
    std = 4.0 / norm.ppf(0.9)
    assert zone_radius_m(STD_TO_80_PERCENT * std, 0.8, 10.0, 1.0, 8) == pytest.approx(120.0, rel=1e-12)


def test_violation_is_29():
    assert violates(120.0, 120.0)
    assert violates(119.9, 120.0)
    assert not violates(math.nextafter(120.0, 121.0), 120.0)
