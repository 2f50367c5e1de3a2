"""Worlds with an estimator or a tracker that has no branch of its own: equal to those that have, and kept apart."""

import copy
import functools
import pickle
import time

import numpy as np
import pytest

import rss_gym
from rss_gym import variants, world
from rss_gym.core import Batch
from rss_gym.eval import evaluate
from rss_gym.eval.studies.calibration.figures import colour_of
from rss_gym.eval.studies.calibration.methods import methods
from rss_gym.jit import digest_of, kernel
from rss_gym.params import Params, ParamsError
from rss_gym.ranging import ESTIMATORS, Estimator, Filter, filters, log_distance
from rss_gym.ranging.track import track
from rss_gym.testing.flights import fly_on, fresh
from rss_gym.tracking import TRACKERS, Tracker, fused
from rss_gym.tracking.record import FUSED_COLUMNS

# The package's own filters by their functions, for the general loop.
COLOURED = Filter(filters.range_prior, filters.predict_coloured, filters.update_coloured, filters.start_coloured)
WHITE = Filter(filters.white_prior, filters.predict_white, filters.update_white, filters.start_white)


WHITE_PARTS = (filters.white_prior, filters.predict_white)


@pytest.fixture
def copies():
    """The package's filters and a tracker under other names."""
    rss_gym.register_estimator("copy-of-ekf-coloured", Estimator("copy", COLOURED))
    rss_gym.register_estimator("copy-of-ekf-white", Estimator("copy", WHITE, white_is_total=True))
    rss_gym.register_tracker("copy-of-fused", Tracker("copy", fused.advance, FUSED_COLUMNS))
    yield
    for registry in (ESTIMATORS, TRACKERS):
        for name in set(registry) - set(registry.shipped):
            registry.remove(name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("own", "other"),
    [
        ({"estimator": "ekf-coloured"}, {"estimator": "copy-of-ekf-coloured"}),
        ({"estimator": "ekf-white"}, {"estimator": "copy-of-ekf-white"}),
        ({"tracker": "fused"}, {"tracker": "copy-of-fused"}),
    ],
)
def test_a_part_of_the_package_under_another_name_flies_the_same_bit_for_bit(copies, own, other):
    one, two = (fresh(Params.of(intruders=2, **keywords), 20) for keywords in (own, other))
    for _ in range(80):
        np.testing.assert_array_equal(one.observations, two.observations)
        fly_on(one, 1)
        fly_on(two, 1)


def test_the_package_s_own_parts_fly_in_the_one_compiled_world():
    for estimator in ("ls", "ekf-white-r", "ekf-white", "ekf-coloured"):
        for tracker in ("latest", "fused"):
            assert variants.kernels(Params.of(estimator=estimator, tracker=tracker)) == (world.reset, world.step)
    assert variants.kernels(Params.of(information="ranges")) == (world.reset, world.step)


def test_a_copied_environment_goes_on_alike():
    batch = fresh(Params.of(estimator="ekf-log"), 3)
    fly_on(batch, 20)
    for twin in (copy.deepcopy(batch), pickle.loads(pickle.dumps(batch))):
        there = copy.deepcopy(batch)
        fly_on(there, 5)
        fly_on(twin, 5)
        np.testing.assert_array_equal(twin.observations, there.observations)


def test_the_logarithmic_filter_ranges_as_over_records():
    """In the world it gives what `track` gives for the RSS that the world has seen, with a decision a tick."""
    params = Params.of(estimator="ekf-log", decision_s=0.1, families="crossing")
    batch = fresh(params, 1)
    rss, ranges = [], []
    while not batch.episode["warned_s"][0] >= 0.0:  # afterwards messages give a psi
        rss.append(batch.state.link_lanes["rss_dbm"][0, 0])
        ranges.append(batch.state.links["range_m"][0, 0])
        fly_on(batch, 1)
    assert len(rss) > 20
    found = track("ekf-log", 0.1 * np.arange(len(rss)), rss, params.channels[0]).range_m
    np.testing.assert_allclose(ranges, found, rtol=1e-9)


@pytest.mark.slow
def test_it_flies_on_a_road():
    pytest.importorskip("highway_env")
    import gymnasium as gym

    env = gym.make("rss_gym/Highway-v0", estimator="ekf-log")
    env.reset(seed=0)
    observation, *_ = env.step(1)  # highway-env's meta-action IDLE
    assert np.isfinite(observation).all()
    env.close()


def test_parts_for_records_only_do_not_fly():
    with pytest.raises(ParamsError, match="estimator = 'ls-window' is unknown"):
        Params.of(estimator="ls-window")


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (COLOURED, "must be a rss_gym.ranging.Estimator, got Filter"),
        (Estimator(" ", COLOURED), "must have a title"),
        (Estimator("x"), "must have a filter, or a run over records"),
        (Estimator("x", COLOURED, code=0), "code must be -1, got 0"),
        (Estimator("x", len), "filter must be a rss_gym.ranging.Filter, got builtin_function_or_method"),
        (Estimator("x", Filter(filters.range_prior, None, None)), "predict must be a function, got None"),
        (Estimator("x", Filter(*[filters.range_prior] * 3)), "predict must take 6 arguments, got 1"),
        (Estimator("x", run=filters.range_prior), "run must take 5 arguments, got 1"),
    ],
)
def test_what_is_no_estimator_is_refused(part, words):
    with pytest.raises(ParamsError, match=words) as caught:
        rss_gym.register_estimator("mine", part)
    assert "\n" not in str(caught.value) and "mine" not in ESTIMATORS


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (fused, "must be a rss_gym.tracking.Tracker, got module"),
        (Tracker("", fused.advance), "must have a summary"),
        (Tracker("x", fused.advance, columns=0), r"columns must be a whole number in \[1, 10000\], got 0"),
        (Tracker("x", fused.advance, information=("oracle",)), "information must hold 'positions', 'ranges' or both"),
        (Tracker("x", fused.advance, code=1), "code must be -1, got 1"),
        (Tracker("x", filters.range_prior), "advance must be a function"),
    ],
)
def test_what_is_no_tracker_is_refused(part, words):
    with pytest.raises(ParamsError, match=words):
        rss_gym.register_tracker("mine", part)
    assert "mine" not in TRACKERS


def misspelt(state, rss_dbm, setting):
    return setting.offset_dbmm, 0.0, 1.0, 0.0, 0.0


def too_few(state, rss_dbm, setting):
    return 1.0, 0.0


def lost(own, other, memory, track, model):
    track.valid = other.heard


@pytest.mark.slow
@pytest.mark.parametrize(
    ("register", "keywords", "words"),
    [
        (
            lambda: rss_gym.register_estimator("mine", Estimator("mine", Filter(*WHITE_PARTS, misspelt))),
            {"estimator": "mine"},
            ["estimator 'mine' cannot be compiled by Numba: ", "test_variants.py, line", "offset_dbmm"],
        ),
        (
            lambda: rss_gym.register_estimator("mine", Estimator("mine", Filter(*WHITE_PARTS, too_few))),
            {"estimator": "mine"},
            ["estimator 'mine' cannot be compiled by Numba: "],
        ),
        (
            lambda: rss_gym.register_tracker("mine", Tracker("mine", lost)),
            {"tracker": "mine"},
            ["tracker 'mine' cannot be compiled by Numba: KeyError: 'heard'"],
        ),
    ],
)
def test_a_part_that_does_not_compile_is_one_sentence(copies, register, keywords, words):
    register()
    with pytest.raises(ParamsError) as caught:
        fresh(Params.of(**keywords), 1)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 600
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_run_over_records_that_does_not_compile_is_one_sentence(copies):
    rss_gym.register_estimator("mine", Estimator("mine", Filter(*WHITE_PARTS, misspelt)))
    with pytest.raises(ParamsError, match=r"estimator 'mine' cannot be compiled by Numba: .*offset_dbmm") as caught:
        track("mine", [0.0, 1.0], [-80.0, -81.0], Params().channels[0])
    assert "\n" not in str(caught.value)


FACTOR = 2.0


def scaled(x):
    return FACTOR * x


def twice(x):
    return scaled(x)


def thrice(x):
    return 3.0 * x


def made(factor):
    return lambda x: factor * x


def test_the_digest_of_a_part_follows_code_values_and_callees(monkeypatch):
    before = digest_of(twice)
    assert digest_of(twice) == before != digest_of(thrice)
    assert digest_of(kernel(cache=False)(twice)) == before
    assert digest_of(made(1.0)) == digest_of(made(1.0)) != digest_of(made(2.0))
    assert digest_of(functools.partial) != before
    monkeypatch.setitem(globals(), "FACTOR", 2.5)
    assert digest_of(twice) != before
    monkeypatch.setitem(globals(), "FACTOR", np.array([2.0]))
    assert digest_of(twice) not in (before, digest_of(thrice))


def test_two_parts_are_kept_apart_and_the_package_s_cache_is_left_alone():
    log = ESTIMATORS["ekf-log"]
    other = Estimator("x", Filter(log_distance.prior, log_distance.predict_state, log_distance.update_state))
    digests = {variants.digest(log), variants.digest(other), variants.digest(log, TRACKERS["fused"])}
    assert len(digests) == 3


def test_scores_of_a_registered_estimator(copies):
    result = evaluate("none", episodes=40, estimator="copy-of-ekf-coloured", progress=False)
    assert result["none"] == evaluate("none", episodes=40, progress=False)["none"]
    assert isinstance(Batch(Params.of(estimator="copy-of-ekf-coloured"), 1), Batch)


def test_a_registered_estimator_is_compared_with_the_others(copies):
    found = methods()
    assert found["copy-of-ekf-white"].title == "copy"
    assert found["copy-of-ekf-white-rate"].base == "copy-of-ekf-white"
    assert colour_of("copy-of-ekf-white-rate") == colour_of("copy-of-ekf-white")


def test_looking_up_the_world_of_a_part_costs_little():
    params = Params()
    variants.kernels(params)
    start = time.process_time()
    for _ in range(1000):
        variants.kernels(params)
    assert time.process_time() - start < 0.05
