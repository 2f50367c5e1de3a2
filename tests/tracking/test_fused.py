"""The filter of messages, velocities and range against filterpy, its symmetries, and its consistency."""

import numpy as np
import pytest
import sensed_flights as sensing
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from rss_gym.tracking import fused, latest
from rss_gym.tracking.record import COVARIANCE, FUSED_COLUMNS, STATE

root = st.lists(st.floats(-1.0, 1.0), min_size=36, max_size=36)
state = st.lists(st.floats(-50.0, 50.0), min_size=6, max_size=6)
SCALE = np.diag([9.0, 9.0, 0.3, 0.3, 8.0, 8.0])


def memory_of(x, entries):
    a = np.reshape(entries, (6, 6))
    p = SCALE @ (a @ a.T + 0.05 * np.eye(6)) @ SCALE
    p = 0.5 * (p + p.T)
    m = np.zeros(FUSED_COLUMNS)
    m[STATE : STATE + 6], m[COVARIANCE:FUSED_COLUMNS] = x, p.ravel()
    return m, p


def parts(m):
    return m[STATE : STATE + 6], m[COVARIANCE:FUSED_COLUMNS].reshape(6, 6)


@given(state, root)
def test_predict_is_filterpys(x, entries):
    m, p = memory_of(x, entries)
    kf = KalmanFilter(dim_x=6, dim_z=1)
    kf.x, kf.P, t = np.array(x), p.copy(), 0.5
    kf.F = np.diag([1.0, 1.0, 0.99, 0.99, 0.9, 0.9])
    kf.F[0, 2] = kf.F[1, 3] = -t
    kf.Q, kf.B = np.diag([0.3, 0.3, 0.01, 0.01, 5.0, 5.0]), np.eye(6)[:, :2]
    kf.predict(u=np.array([1.5, -2.0]))
    fused.predict(m, 1.5, -2.0, t, 0.99, 0.9, 0.3, 0.01, 5.0)
    got_x, got_p = parts(m)
    np.testing.assert_allclose(got_x, kf.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(got_p, kf.P, rtol=1e-9, atol=1e-9)


@given(state, root, st.floats(-60.0, 60.0), st.sampled_from([0, 1]))
def test_a_message_is_filterpys_update(x, entries, z, axis):
    m, p = memory_of(x, entries)
    kf = KalmanFilter(dim_x=6, dim_z=1)
    kf.x, kf.P, kf.R, kf.H = np.array(x), p.copy(), np.array([[4.0]]), np.zeros((1, 6))
    kf.H[0, axis] = kf.H[0, 4 + axis] = 1.0
    kf.update(np.array([z]))
    fused.update_by_message(m, axis, z, 4.0)
    got_x, got_p = parts(m)
    np.testing.assert_allclose(got_x, kf.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(got_p, kf.P, rtol=1e-9, atol=1e-9)


@given(state, root, st.floats(5.0, 90.0))
def test_a_range_is_filterpys_extended_update(x, entries, range_m):
    """The noise is the range's and what the bearing's error adds, by quadrature over the wrapped normal."""
    x[0] += 60.0
    m, p = memory_of(x, entries)
    d = np.hypot(x[0], x[1])
    n = np.array([x[0], x[1]]) / d
    across = np.array([-n[1], n[0]])
    q = across @ p[:2, :2] @ across / (range_m * d)
    angle = np.linspace(-12.0, 12.0, 20001) * np.sqrt(q)
    weight = np.exp(-0.5 * angle**2 / q)
    cosine = np.cos(angle)
    mean = np.sum(weight * cosine) / np.sum(weight)
    bent = range_m**2 * np.sum(weight * (cosine - mean) ** 2) / np.sum(weight)
    ekf = ExtendedKalmanFilter(dim_x=6, dim_z=1)
    ekf.x, ekf.P, ekf.R = np.array(x), p.copy(), np.array([[3.0 * (7.0 + bent)]])
    ekf.update(
        np.array([range_m]),
        lambda c: np.concatenate([c[:2] / np.hypot(c[0], c[1]), np.zeros(4)])[None],
        lambda c: np.array([np.hypot(c[0], c[1])]),
    )
    fused.update_by_range(m, range_m, 7.0, 3.0)
    got_x, got_p = parts(m)
    np.testing.assert_allclose(got_x, ekf.x, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(got_p, ekf.P, rtol=1e-6, atol=1e-6)


@given(st.floats(1.0, 90.0), st.floats(0.01, 30.0), st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_covariances_stay_symmetric_and_positive(range_m, std_m, seed):
    """Whatever is sensed, also what contradicts the message before."""
    rng, constants = np.random.default_rng(seed), sensing.tracker_model()
    memory, track = sensing.empty("fused")
    for _ in range(30):
        own, other = sensing.records(
            own_position_m=rng.normal(0.0, 20.0, 3) * (1, 1, 0), own_std_m=std_m,
            range_m=range_m * rng.uniform(0.05, 3.0), range_std_m=rng.uniform(0.01, 40.0),
            position_m=rng.normal(0.0, 60.0, 3) * (1, 1, 0), std_m=rng.uniform(0.1, 50.0),
            velocity_mps=rng.normal(0.0, 3.0, 3) * (1, 1, 0), age_s=rng.choice([0.0, 0.5, 3.0]),
        )  # fmt: skip
        fused.advance(own, other, memory, track, constants)
        _, p = parts(memory)
        scale = np.sqrt(np.diag(p))
        np.testing.assert_allclose(p / np.outer(scale, scale), p.T / np.outer(scale, scale), atol=1e-12)
        assert np.linalg.eigvalsh(p / np.outer(scale, scale)).min() > -1e-9
        published = np.array([[track["xx"], track["xy"]], [track["xy"], track["yy"]]])
        assert np.linalg.eigvalsh(published).min() > 0.0
        assert np.isfinite(track["position_m"]).all()


def turned(records, c, s, names):
    out = records.copy()
    for name in names:
        x, y = records[name][..., 0], records[name][..., 1]
        out[name][..., 0], out[name][..., 1] = c * x - s * y, s * x + c * y
    return out


@given(st.floats(-3.14, 3.14), st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_rotation_of_the_world_rotates_the_track(angle, seed):
    _, own, other = sensing.flights(np.random.default_rng(seed), 1, 60, 6.0, 4.0)
    c, s = np.cos(angle), np.sin(angle)
    one = sensing.fly(fused, "fused", own, other, sensing.tracker_model())
    two = sensing.fly(
        fused, "fused", turned(own, c, s, ("position_m", "velocity_mps")),
        turned(other, c, s, ("position_m", "velocity_mps")), sensing.tracker_model(),
    )  # fmt: skip
    expected = turned(one, c, s, ("position_m",))
    np.testing.assert_allclose(two["position_m"], expected["position_m"], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(two["xx"] + two["yy"], one["xx"] + one["yy"], rtol=1e-5)
    np.testing.assert_allclose(
        two["xx"] * two["yy"] - two["xy"] ** 2, one["xx"] * one["yy"] - one["xy"] ** 2, rtol=1e-4
    )


def test_an_episode_before_is_forgotten():
    memory, track = sensing.empty("fused")
    constants = sensing.tracker_model()
    fused.advance(*sensing.records(position_m=(-20.0, 40.0, 0.0)), memory, track, constants)
    memory[:] = 0.0
    fused.advance(*sensing.records(), memory, track, constants)
    fresh, alone = sensing.empty("fused")
    fused.advance(*sensing.records(), fresh, alone, constants)
    assert track.tobytes() == alone.tobytes()


def test_silence_widens_the_track_and_a_message_narrows_it():
    memory, track = sensing.empty("fused")
    constants, spread = sensing.tracker_model(), []
    for n in range(40):
        silent = 10 <= n < 30
        age = 0.5 * (n - 9) if silent else 0.0
        heard = (78.0 - 3.0 * (9 if silent else n), 10.0, 0.0)
        own, other = sensing.records(
            own_position_m=(1.5 * n, 0.0, 0.0), position_m=heard, age_s=age, range_m=300.0, range_std_m=250.0
        )
        fused.advance(own, other, memory, track, constants)
        spread.append(track["xx"] + track["yy"])
    assert spread[29] > 2.0 * spread[9]
    assert spread[39] < 0.6 * spread[29]


def test_the_height_is_the_messages():
    memory, track = sensing.empty("fused")
    constants = sensing.tracker_model(planar=False)
    own, other = sensing.records(own_position_m=(0.0, 0.0, 20.0), position_m=(70.0, 0.0, 32.0), range_m=71.0)
    fused.advance(own, other, memory, track, constants)
    assert track["position_m"][2] == 12.0
    assert track["zz"] == pytest.approx(2.0 * (1.0**2 + 3.0**2))


def test_errors_are_as_stated_and_less_than_half_the_messages_near_the_other():
    """Forty flights past each other at up to 15 m: rms(error / std) near 1, and the message beaten where it counts."""
    truth, own, other = sensing.flights(np.random.default_rng(7), 40, 80, 6.0, 4.0)
    constants = sensing.tracker_model()
    d = np.linalg.norm(truth, axis=-1)
    along, across, error = sensing.standardised(sensing.fly(fused, "fused", own, other, constants), truth)
    _, _, held = sensing.standardised(sensing.fly(latest, "latest", own, other, constants), truth)
    for low, high in ((0.0, 20.0), (20.0, 40.0), (40.0, 60.0), (60.0, 90.0)):
        inside = (d >= low) & (d < high)
        assert 0.5 < sensing.rms(along[inside]) < 1.5
        assert 0.5 < sensing.rms(across[inside]) < 1.5
    near = d < 20.0
    assert sensing.rms(error[near]) < 0.6 * sensing.rms(held[near])
