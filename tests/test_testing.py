"""The contract tests that users call find what is wrong."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import rss_gym
from rss_gym import registry, testing
from rss_gym.baselines.policy import Scripted
from rss_gym.encounters.family import Complication, Family
from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics import Metric
from rss_gym.eval.suites import SUITES
from rss_gym.params import Params, ParamsError
from rss_gym.ranging import Estimator, Filter, filters
from rss_gym.testing.metric import check_declaration
from rss_gym.tracking import Tracker


@pytest.fixture(autouse=True)
def forget():
    """Removes afterwards what a test registers."""
    yield
    for kind in registry.HOMES:
        for name in set(registry.of(kind)) - set(registry.of(kind).shipped):
            registry.of(kind).remove(name)


# -- policies ---------------------------------------------------------------------------------------------------------


class Still:
    """A policy that keeps the contract."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        rows = np.atleast_2d(observation)
        actions = self.actions(rows)
        return (actions if np.ndim(observation) > 1 else actions[0]), state

    def actions(self, rows):
        return np.zeros((len(rows), 2), np.float32)


class Double(Still):
    def actions(self, rows):
        return np.zeros((len(rows), 2))


class Wide(Still):
    def actions(self, rows):
        return np.full((len(rows), 2), 1.5, np.float32)


class Lost(Still):
    def actions(self, rows):
        return np.full((len(rows), 2), np.nan, np.float32)


class Spatial(Still):
    def actions(self, rows):
        return np.zeros((len(rows), 3), np.float32)


class Together(Still):
    def actions(self, rows):
        return np.full((len(rows), 2), 1.0 / len(rows), np.float32)


class Careless(Still):
    def actions(self, rows):
        rows[:, 0] += 1.0
        return np.zeros((len(rows), 2), np.float32)


class Forgetless(Still):
    """Never clears its memory."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        rows = np.atleast_2d(observation)
        state = np.zeros(len(rows)) if state is None else state + 1.0
        actions = np.repeat(np.minimum(0.01 * state, 1.0)[:, None], 2, axis=1).astype(np.float32)
        return (actions if np.ndim(observation) > 1 else actions[0]), state


def test_a_sound_policy_passes():
    testing.check_policy(Still(), Params())


@pytest.mark.parametrize(
    ("policy", "words"),
    [
        (Double(), "must be float32"),
        (Wide(), r"outside \[-1, 1\]"),
        (Lost(), "not finite"),
        (Spatial(), r"must have the shape \(5, 2\)"),
        (Together(), "depends on the other rows"),
        (Careless(), "changes the observations"),
        (Forgetless(), "memory is not cleared"),
    ],
)
def test_an_unsound_policy_is_found(policy, words):
    with pytest.raises(AssertionError, match=words):
        testing.check_policy(policy, Params())


@dataclass(frozen=True, kw_only=True)
class Mute(Scripted):
    """Has a summary that is no sentence"""

    def act(self, seen, memory):
        return np.zeros((len(memory), 3))


@dataclass(frozen=True, kw_only=True)
class Averse(Scripted):
    """Divides by what may be zero."""

    def act(self, seen, memory):
        return np.full((len(memory), 3), np.where(seen["warning"].any(), np.nan, 0.0))


@pytest.mark.parametrize(("rule", "words"), [(Mute, "must be a sentence"), (Averse, "not finite")])
def test_an_unsound_rule_is_found(rule, words):
    rss_gym.register_rule("mine", rule)
    with pytest.raises(AssertionError, match=words):
        testing.check_rule("mine")


# -- metrics ----------------------------------------------------------------------------------------------------------


def first(flights):
    """The first encounter's deviation."""
    return mean_t(flights.table["deviation_mean_m"][:1])


def undefined(flights):
    """Not a number without flights."""
    return Interval(float(np.sum(flights.table["flown_s"])) / max(len(flights), 1), 1e9, None, len(flights))


def scribbles(flights):
    """Writes into the table."""
    found = mean_t(flights.table["deviation_mean_m"])
    flights.table["deviation_mean_m"] = 0.0
    return found


def nominal(flights):
    """A property of the radio alone."""
    return mean_t(flights.none["sample_range_m"])


@pytest.mark.parametrize(
    ("name", "metric", "words"),
    [
        ("mine_m", Metric("first", "m", first), "order of the rows"),
        ("mine_s", Metric("no interval", "s", undefined), "interval must hold the value"),
        ("mine_m", Metric("scribbles", "m", scribbles), "depends on the order|tables are changed"),
        ("mine_m", Metric("of none", "m", nominal), "`sensor` must say"),
    ],
)
def test_an_unsound_metric_is_found(name, metric, words):
    rss_gym.register_metric(name, metric)
    with pytest.raises(AssertionError, match=words):
        testing.check_metric(name)


@pytest.mark.parametrize(
    ("name", "metric", "words"),
    [
        ("mine", Metric("x", "m", first), "must end in its unit"),
        ("mine_m", Metric("x", "1", first), "must end in its unit"),
        ("mine_m", Metric("x", "metres", first), "unit 'metres' must be one of"),
        ("mine_m", Metric("x", "m", lambda flights: None), "no docstring"),
    ],
)
def test_a_metric_that_does_not_say_what_it_is_is_found(name, metric, words):
    rss_gym.register_metric(name, metric)
    with pytest.raises(AssertionError, match=words):
        check_declaration(name)


# -- the radio --------------------------------------------------------------------------------------------------------


def update_to_nan(state, rss_dbm, setting):
    return np.nan, 0.0, 1.0, 0.0, 0.0


def update_to_prior(state, rss_dbm, setting):
    return state


def update_unsure(state, rss_dbm, setting):
    d, phi, _, p_dp, p_pp = filters.update_white(state, rss_dbm, setting)
    return d, phi, -1.0, p_dp, p_pp


@pytest.mark.parametrize(
    ("update", "words"),
    [
        (update_to_nan, "range is not finite"),
        (update_to_prior, "farther from the truth than the prior"),
        (update_unsure, "variance is negative"),
    ],
)
def test_an_unsound_estimator_is_found(update, words):
    part = Estimator("mine", Filter(filters.white_prior, filters.predict_white, update))
    rss_gym.register_estimator("mine", part)
    with pytest.raises(AssertionError, match=words):
        testing.check_estimator("mine")


def silent(own, other, memory, track, model):
    """Writes no track."""
    track.valid = False


def correlated(own, other, memory, track, model):
    """Its covariance is none."""
    track.valid = other.valid
    for axis in range(3):
        track.position_m[axis] = track.velocity_mps[axis] = 1.0
    track.xx = track.yy = track.zz = 1.0
    track.xy = 2.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("advance", "words"), [(silent, "no track where a message is held"), (correlated, "are no covariance")]
)
def test_an_unsound_tracker_is_found(advance, words):
    rss_gym.register_tracker("mine", Tracker("mine", advance))
    with pytest.raises(AssertionError, match=words):
        testing.check_tracker("mine")


# -- encounters -------------------------------------------------------------------------------------------------------


def test_a_sound_family_passes():
    rss_gym.register_family("mine", Family(summary="from behind", weight=0.0, faster=True))
    testing.check_family("mine", several=2)


def test_a_family_that_cannot_be_drawn_is_found():
    beyond = Complication(speed_change_mps=(10.0, 20.0))  # of all cruise speeds
    rss_gym.register_family("mine", Family(summary="never", weight=0.0, complication=beyond))
    with pytest.raises(ParamsError, match="no encounter of families 'mine' meets the limits"):
        testing.check_family("mine")


def test_an_unsound_suite_is_found(monkeypatch):
    rss_gym.register_suite(replace(SUITES["smoke-v0"], name="mine-v0"))
    testing.check_suite("mine-v0")
    monkeypatch.setattr(type(SUITES["mine-v0"]), "hash", "always the same")
    with pytest.raises(AssertionError, match="hash must cover the name"):
        testing.check_suite("mine-v0")
