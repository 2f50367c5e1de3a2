"""`track`: every estimator over records, irregular, missing, quantised, alone and in batches."""

import math
import re

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from rss_gym.params import Channel, ParamsError, load_channel
from rss_gym.physics.noise import decay, driving_std
from rss_gym.ranging import ESTIMATORS, coloured
from rss_gym.ranging.track import RangeTrack, Tuning, track

EVERY = pytest.mark.parametrize("name", ESTIMATORS)
FILTERS = tuple(name for name in ESTIMATORS if name.startswith("ekf"))
PAPER = load_channel("outdoor")
FIELDS = ("range_m", "coloured_db", "covariance", "innovation_db", "innovation_variance_db2")


def flight(seed, samples, channel=PAPER, irregular=True, lost=0.2):
    """Times, RSS with lost samples, range rate with unknown ones, of an aircraft that passes at 5 m and 4 m/s."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.02, 0.5, samples) if irregular else np.full(samples, 0.125)
    time = np.cumsum(steps)
    along = 80.0 - 4.0 * (time - time[0])
    distance = np.hypot(along, 5.0)
    noise, phi = np.empty(samples), math.sqrt(channel.coloured_variance_db2) * rng.standard_normal()
    for n in range(samples):
        a = math.exp(-steps[n] / channel.coloured_tc_s)
        phi = a * phi + math.sqrt(channel.coloured_variance_db2 * (1.0 - a * a)) * rng.standard_normal()
        noise[n] = phi
    rss = channel.offset_dbm - 10.0 * channel.path_loss_factor * np.log10(distance) + noise
    rss += math.sqrt(channel.white_variance_db2) * rng.standard_normal(samples)
    rss[rng.random(samples) < lost] = np.nan
    rate = np.where(rng.random(samples) < 0.5, -4.0 * along / distance, np.nan)
    return time, rss, rate


def oracle(name, time, rss, rate, channel, tuning):
    """The same by filterpy: the EKF, and its linear filter in ln d for the first sample. Yields x and P by sample."""
    states = 2 if "coloured" in name else 1
    r, s = channel.white_variance_db2, channel.coloured_variance_db2
    r += 0.0 if states == 2 or name == "ekf-white-r" else s
    gamma, offset = channel.path_loss_factor, channel.offset_dbm
    ekf = ExtendedKalmanFilter(dim_x=states, dim_z=1)
    ekf.R = np.array([[r]])
    ekf.x, ekf.P = np.array([tuning.prior_range_m, 0.0])[:states], np.diag([tuning.prior_std_m**2, s])[:states, :states]
    if name.endswith("literal"):
        ekf.x = np.array([10.0 ** ((offset - rss[0]) / (10.0 * gamma)), 0.0])[:states]
        ekf.P = np.eye(states)
    else:
        first = KalmanFilter(dim_x=states, dim_z=1)
        first.x = np.array([math.log(tuning.prior_range_m), 0.0])[:states]
        first.P = np.diag([(tuning.prior_std_m / tuning.prior_range_m) ** 2, s])[:states, :states]
        first.H, first.R = np.array([[-10.0 * gamma / math.log(10.0), 1.0]])[:, :states], ekf.R
        first.update(np.array([rss[0] - offset]))
        d = math.exp(first.x[0])
        scale = np.diag([d, 1.0])[:states, :states]
        ekf.x, ekf.P = np.array([d, *first.x[1:]]), scale @ first.P @ scale
    ekf.B = np.array([1.0, 0.0])[:states]
    yield ekf.x.copy(), ekf.P.copy()
    for n in range(1, len(time)):
        interval, known = time[n] - time[n - 1], not math.isnan(rate[n])
        a = math.exp(-interval / channel.coloured_tc_s)
        noise = tuning.process_noise_rate_m2_ps if known else tuning.process_noise_m2_ps
        ekf.F = np.diag([1.0, a])[:states, :states]
        ekf.Q = np.diag([noise * interval, s * (1.0 - a * a)])[:states, :states]
        ekf.predict(u=rate[n] * interval if known else 0.0)
        ekf.x[0] = max(ekf.x[0], tuning.range_floor_m)
        if not math.isnan(rss[n]):
            ekf.update(
                np.array([rss[n]]),
                lambda x: np.array([[-10.0 * gamma / (x[0] * math.log(10.0)), 1.0]])[:, :states],
                lambda x: np.array([offset - 10.0 * gamma * math.log10(x[0]) + sum(x[1:])]),
            )
            ekf.x[0] = max(ekf.x[0], tuning.range_floor_m)
        yield ekf.x.copy(), ekf.P.copy()


@pytest.mark.parametrize("name", [name for name in FILTERS if name != "ekf-log"])
@pytest.mark.parametrize("preset", ["paper", "quadcopter"])
def test_filters_equal_filterpy(name, preset):
    """300 irregular samples, a fifth of them missing, psi known at half of them: state and covariance to 1e-9."""
    channel, tuning = load_channel(preset), Tuning(process_noise_m2_ps=40.0, prior_range_m=90.0, prior_std_m=30.0)
    time, rss, rate = flight(len(preset), 300, channel)
    rss[0] = -80.0
    out = track(name, time, rss, channel, tuning, rate)
    for n, (x, p) in enumerate(oracle(name, time, rss, rate, channel, tuning)):
        p_dd, p_dp, p_pp = out.covariance[n]
        mine = np.array([[p_dd, p_dp], [p_dp, p_pp]])[: len(x), : len(x)]
        np.testing.assert_allclose([out.range_m[n], out.coloured_db[n]][: len(x)], x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(mine, p, rtol=1e-9, atol=1e-9)


def test_names_and_kernels_are_the_worlds():
    """The world's names are here, and at its tick the coloured filter is a loop over its kernels, bit for bit."""
    assert [name for name, part in ESTIMATORS.items() if part.code >= 0] == [
        "ls",
        "ekf-white-r",
        "ekf-white",
        "ekf-coloured",
    ]
    time, rss, _ = flight(1, 200, irregular=False)
    rss[0] = -85.0
    out, tuning = track("ekf-coloured", time, rss, PAPER), Tuning()
    a = decay(0.125, PAPER.coloured_tc_s)
    drive = driving_std(PAPER.coloured_variance_db2, a)
    channel = PAPER.offset_dbm, PAPER.path_loss_factor, PAPER.white_variance_db2
    state = coloured.start(tuning.prior_range_m, tuning.prior_std_m, PAPER.coloured_variance_db2, -85.0, *channel)
    for n in range(200):
        if n > 0:
            state = coloured.predict(*state, 0.0, tuning.process_noise_m2_ps * 0.125, a, drive)
            state = max(state[0], tuning.range_floor_m), *state[1:]
            if not np.isnan(rss[n]):
                state = coloured.update(*state, rss[n], *channel, tuning.range_floor_m)
        assert (out.range_m[n], out.coloured_db[n], *out.covariance[n]) == state


@EVERY
@pytest.mark.parametrize("own_times", [False, True])
def test_a_row_of_a_batch_is_the_record_alone(name, own_times):
    """Bit for bit, whatever the other rows are and in whatever order."""
    records = [flight(seed, 120) for seed in range(4)]
    time, rss, rate = (np.stack(column) for column in zip(*records, strict=True))
    if not own_times:
        time, rate = time[0], rate[0]
    together = track(name, time, rss, PAPER, range_rate_mps=rate)
    turned = track(name, time[::-1] if own_times else time, rss[::-1], PAPER,
                   range_rate_mps=rate[::-1] if own_times else rate)  # fmt: skip
    for k in range(4):
        alone = track(
            name, time[k] if own_times else time, rss[k], PAPER, range_rate_mps=rate[k] if own_times else rate
        )
        for field in FIELDS:
            np.testing.assert_array_equal(getattr(together, field)[k], getattr(alone, field), strict=True)
            np.testing.assert_array_equal(getattr(turned, field)[3 - k], getattr(alone, field), strict=True)


@EVERY
def test_missing_first_samples(name):
    """From the first sample on, the record is as if it began there; before it a prior filter says its prior."""
    time, rss, rate = flight(5, 60)
    rss[:7], rss[7] = np.nan, -84.0
    out = track(name, time, rss, PAPER, range_rate_mps=rate)
    late = track(name, time[7:], rss[7:], PAPER, range_rate_mps=rate[7:])
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(out, field)[7:], getattr(late, field))
    assert np.isfinite(out.range_m[7:]).all()
    assert np.isnan(out.innovation_db[:7]).all()
    if name in FILTERS and not name.endswith("literal"):
        np.testing.assert_allclose(out.range_m[:7], Tuning().prior_range_m, rtol=1e-14)
        np.testing.assert_allclose(out.range_std_m[:7], Tuning().prior_std_m, rtol=1e-14)
    else:
        assert np.isnan(out.range_m[:7]).all()


@pytest.mark.parametrize("name", FILTERS)
def test_a_record_without_a_sample_and_one_with_a_long_gap(name):
    silent = track(name, [0.0, 1.0], [np.nan, np.nan], PAPER)
    assert np.isnan(silent.innovation_db).all()
    out = track(name, [0.0, 1.0, 1e5, 1e5 + 1.0], [-80.0, -82.0, np.nan, -81.0], PAPER)
    assert np.isfinite(out.covariance).all()
    assert np.isfinite(out.range_m).all()
    if "white" not in name:  # 50,000 Tc later nothing is known of the coloured noise
        assert out.coloured_db[2] == pytest.approx(0.0, abs=1e-12)
        assert out.covariance[2, 2] == pytest.approx(PAPER.coloured_variance_db2, rel=1e-12)


def test_regular_times_share_an_interval_and_rounding_of_times_is_harmless():
    """k / 10 is not a multiple of 0.1 in binary: shifted times agree to the rounding of their differences."""
    _, rss, _ = flight(6, 300)
    time = np.arange(300) / 10.0
    near, far = track("ekf-coloured", time, rss, PAPER), track("ekf-coloured", time + 1e4, rss, PAPER)
    np.testing.assert_allclose(near.range_m, far.range_m, rtol=1e-8)


def test_least_squares_inverts_each_sample_and_holds_the_last():
    out = track("ls", [0.0, 1.0, 2.5, 3.0], [np.nan, -35.0 - 27.0, np.nan, -35.0 - 54.0], PAPER)
    np.testing.assert_allclose(out.range_m, [np.nan, 10.0, 10.0, 100.0], rtol=1e-12)
    std = math.sqrt(PAPER.white_variance_db2 + PAPER.coloured_variance_db2) * math.log(10.0) / 27.0
    np.testing.assert_allclose(out.range_std_m, [np.nan, 10.0 * std, 10.0 * std, 100.0 * std], rtol=1e-12)
    deep = track("ls", [0.0, 1.0], [-300.0, 60.0], PAPER)
    assert deep.range_m.tolist() == [Tuning().range_ceiling_m, Tuning().range_floor_m]


@pytest.mark.parametrize("estimator", ["ekf-coloured-literal", "ekf-white-literal"])
def test_the_literal_start(estimator):
    """d(0) is the first sample inverted, phi(0) = 0, P(0) = I (1 for the white filter); nothing is predicted for it."""
    out = track(estimator, [0.0, 1.0], [-62.0, -60.0], PAPER)
    assert out.range_m[0] == pytest.approx(10.0, rel=1e-12)
    assert out.covariance[0].tolist() == [1.0, 0.0, 1.0 if "coloured" in estimator else 0.0]
    assert np.isnan(out.innovation_db[0])
    assert np.isfinite(out.innovation_db[1])


def test_quantised_samples_count_as_noisier_ones():
    """The rounding error of a 4 dB step has the variance 16 / 12 dB^2, which is added to R and nowhere else."""
    time, rss, _ = flight(8, 100)
    rss = np.round(rss / 4.0) * 4.0
    coarse = track("ekf-coloured", time, rss, PAPER.replace(quantisation_db=4.0))
    noisier = track("ekf-coloured", time, rss, PAPER.replace(white_variance_db2=PAPER.white_variance_db2 + 16.0 / 12.0))
    np.testing.assert_array_equal(coarse.range_m, noisier.range_m)
    assert np.isfinite(track("ekf-coloured", time, rss, PAPER.replace(white_variance_db2=0.0)).range_m).all()


@given(
    st.sampled_from(FILTERS),
    st.builds(
        Channel,
        path_loss_factor=st.floats(1.0, 8.0),
        offset_dbm=st.floats(-150.0, 60.0),
        white_variance_db2=st.floats(0.0, 400.0),
        coloured_variance_db2=st.floats(1e-6, 400.0),
        coloured_tc_s=st.floats(0.01, 3600.0),
        quantisation_db=st.floats(0.0, 20.0),
    ),
    st.builds(
        Tuning,
        process_noise_m2_ps=st.floats(1e-3, 1e6),
        process_noise_rate_m2_ps=st.floats(1e-3, 1e6),
        relative_noise_ps=st.floats(1e-6, 10.0),
        relative_noise_rate_ps=st.floats(1e-6, 10.0),
        prior_range_m=st.floats(1.0, 1e4),
        prior_std_m=st.floats(0.1, 1e4),
    ),
    st.lists(
        st.tuples(
            st.floats(1e-3, 1e4),
            st.none() | st.floats(0.3, 1e4),
            st.floats(-30.0, 30.0),
            st.none() | st.floats(-10, 10),
        ),
        min_size=1,
        max_size=30,
    ),
)
def test_ranges_and_covariances_stay_possible(name, channel, tuning, samples):
    """Over the ranges of params.py: finite, the range above its floor, P positive semidefinite, innovations too."""
    time = np.cumsum([interval for interval, _, _, _ in samples])
    heard = channel.offset_dbm - 10.0 * channel.path_loss_factor * np.log10([d or 1.0 for _, d, _, _ in samples])
    rss = [level + noise if d else np.nan for level, (_, d, noise, _) in zip(heard, samples, strict=True)]
    out = track(name, time, rss, channel, tuning, [np.nan if v is None else v for *_, v in samples])
    heard = ~np.isnan(out.range_m)
    assert heard.all() or name.endswith("literal")
    assert (out.range_m[heard] >= tuning.range_floor_m * (1.0 - 1e-12)).all()
    p_xx, p_xp, p_pp = out.covariance[heard].T
    assert np.isfinite(out.covariance[heard]).all()
    assert (p_xx > 0.0).all()
    assert (p_pp >= 0.0).all()
    assert (p_xp**2 <= p_xx * p_pp * (1.0 + 1e-9)).all()
    predicted = ~np.isnan(out.innovation_db)
    assert (out.innovation_variance_db2[predicted] > 0.0).all()


@pytest.mark.parametrize("name", ["ekf-coloured", "ekf-log"])
def test_innovations_are_what_the_update_uses(name):
    """Predicted sample + innovation is the sample: from the state before, at one interval, by hand."""
    time, tuning = np.array([0.0, 0.5]), Tuning()
    out = track(name, time, [-80.0, -77.0], PAPER, tuning)
    gamma = PAPER.path_loss_factor
    # The first sample meets the prior, in metres and in ln d alike.
    h = -10.0 * gamma / math.log(10.0) / tuning.prior_range_m * tuning.prior_std_m
    assert out.innovation_db[0] == pytest.approx(-80.0 + 35.0 + 10.0 * gamma * math.log10(tuning.prior_range_m))
    assert out.innovation_variance_db2[0] == pytest.approx(h * h + 4.0 + 4.0, rel=1e-12)
    a = math.exp(-0.5 / PAPER.coloured_tc_s)
    expected = -35.0 - 10.0 * gamma * math.log10(out.range_m[0]) + a * out.coloured_db[0]
    assert out.innovation_db[1] == pytest.approx(-77.0 - expected, rel=1e-12)
    p_xx, p_xp, p_pp = out.covariance[0]
    p_xx += 0.5 * (tuning.relative_noise_ps if name == "ekf-log" else tuning.process_noise_m2_ps)
    row = np.array([-10.0 * gamma / math.log(10.0) / (1.0 if name == "ekf-log" else out.range_m[0]), 1.0])
    p = np.array([[p_xx, a * p_xp], [a * p_xp, a * a * p_pp + 4.0 * (1.0 - a * a)]])
    assert out.innovation_variance_db2[1] == pytest.approx(row @ p @ row + 4.0, rel=1e-12)
    np.testing.assert_allclose(out.nis, out.innovation_db**2 / out.innovation_variance_db2)


def test_nees_by_hand():
    p = np.array([[9.0, 1.0], [1.0, 4.0]])
    arrays = np.array([10.0]), np.array([1.0]), np.array([[9.0, 1.0, 4.0]]), np.array([2.0]), np.array([8.0])
    out, error = RangeTrack(*arrays), np.array([-2.0, 0.5])
    assert out.nees([12.0])[0] == pytest.approx(4.0 / 9.0)
    assert out.nees([12.0], [0.5])[0] == pytest.approx(error @ np.linalg.inv(p) @ error)
    assert out.nis[0] == 0.5
    logarithmic = RangeTrack(*arrays, logarithmic=True)
    assert logarithmic.nees([12.0])[0] == pytest.approx(math.log(10.0 / 12.0) ** 2 / 9.0)
    assert logarithmic.range_std_m[0] == pytest.approx(30.0)
    with pytest.raises(ParamsError, match="above 0"):
        out.nees([0.0])
    with pytest.raises(ParamsError, match=re.escape("range_true_m must have the shape (1,)")):
        out.nees([1.0, 2.0])
    with pytest.raises(ParamsError, match="no coloured noise"):
        track("ekf-white", [0.0], [-80.0], PAPER).nees([10.0], [0.0])


def test_white_filter_is_consistent_where_its_model_is_the_truth():
    """Without coloured noise, 400 records of 40 samples of a slow range: mean NIS inside its 99.99 % interval."""
    rng = np.random.default_rng(11)
    channel, tuning = Channel(coloured_variance_db2=1e-6), Tuning(process_noise_m2_ps=1.0, prior_std_m=5.0)
    distance = 160.0 + 5.0 * rng.standard_normal((400, 1))
    distance = distance + np.cumsum(math.sqrt(0.1) * rng.standard_normal((400, 40)), axis=1)
    rss = -35.0 - 27.0 * np.log10(distance) + 2.0 * rng.standard_normal((400, 40))
    low, high = chi2.interval(0.9999, rss.size)
    assert low < track("ekf-white", np.arange(40) / 10.0, rss, channel, tuning).nis.sum() < high


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"estimator": "ekf-color"}, "estimator 'ekf-color' is unknown; did you mean 'ekf-coloured'?"),
        ({"estimator": 3}, "estimator 3 is unknown"),
        ({"channel": "paper"}, "channel must be a Channel, got str"),
        ({"tuning": {}}, "tuning must be a Tuning, got dict"),
        ({"time_s": [0.0, 1.0, 1.0]}, "time_s must increase strictly, got 1 s after 1 s at sample 2"),
        ({"time_s": [0.0, np.nan, 1.0]}, "time_s must be finite"),
        ({"time_s": [0.0, 1.0]}, "time_s must have the shape (3,)"),
        ({"rss_dbm": ["a", "b", "c"]}, "rss_dbm must be an array of numbers"),
        ({"rss_dbm": [-80.0, -np.inf, -80.0]}, "rss_dbm must be finite or NaN"),
        ({"rss_dbm": [-80.0, 1e5, -80.0]}, "rss_dbm must lie within 1000 dBm of 0, got 100000"),
        ({"rss_dbm": []}, "at least one sample, got (0,)"),
        ({"rss_dbm": -80.0}, "must have the shape (n,) or (k, n)"),
        ({"range_rate_mps": [1.0]}, "range_rate_mps must have the shape (3,)"),
    ],
)
def test_bad_input(changes, sentence):
    good = {"estimator": "ekf-coloured", "time_s": [0.0, 1.0, 2.0], "rss_dbm": [-80.0, -81.0, -82.0], "channel": PAPER}
    with pytest.raises(ParamsError, match=re.escape(sentence)):
        track(**{**good, **changes})


def test_bad_tuning():
    with pytest.raises(ParamsError, match="prior_std_m must be a number in"):
        Tuning(prior_std_m=-1.0)
