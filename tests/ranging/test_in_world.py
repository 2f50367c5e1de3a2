"""The filter inside the world equals filterpy's on whole recorded episodes.

Radio, noise, psi and process noise of every tick are recomputed here in NumPy from the records: true positions,
messages, and the counter-based normals by their stream numbers. A decision is one tick, so every tick is seen.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter

from rss_gym.core import Batch
from rss_gym.params import Params
from rss_gym.physics.random import normal, uniform
from rss_gym.records import (
    STREAM_LOSS,
    STREAM_START_LINK,
    STREAM_TICK,
    STREAM_WANDER,
    global_link,
)

ROWS = 3
WORLDS = {
    "default": {},
    "3-D": {"planar": False},
    "quadcopter": {"channel": "quadcopter"},
    "three intruders": {"intruders": 3},
    "lossy, coarse and deaf": {
        "channel": {"packet_loss": 0.3, "quantisation_db": 1.0, "sensitivity_dbm": -92.0, "coloured_tc_s": 8.0}
    },
    "range track": {"track": "range"},
    "dead reckoning": {"agent": "dead-reckoning", "intruder": "dead-reckoning"},
    "white filter": {"estimator": "ekf-white"},
}


def record(params, seed):
    """Fly random way points to the end; the state after reset and after each tick, as copies of the records."""
    batch = Batch(params, ROWS)
    batch.seed(np.arange(seed, seed + ROWS, dtype=np.uint64))
    batch.reset(np.ones(ROWS, bool))
    rng, done, frames = np.random.default_rng(seed), np.zeros(ROWS, bool), []
    actions = np.zeros((ROWS, 3))
    while True:
        world = batch.world
        frames.append(
            SimpleNamespace(
                done=done.copy(),
                position=world.aircraft["position_m"].copy(),
                solution=world.aircraft["solution_m"].copy(),
                solution_mps=world.aircraft["solution_mps"].copy(),
                solution_std=world.aircraft["solution_std_m"].copy(),
                link=world.links.copy(),
                contact=world.contacts.copy(),
            )
        )
        if done.all():
            return batch, frames
        if len(frames) % 50 == 1:
            actions = rng.uniform(-1.0, 1.0, (ROWS, 3)) * rng.integers(0, 2)
        batch.step(actions, done)
        done |= batch.episode["terminated"] | batch.episode["truncated"]


def closing(params, before, now, row, k):
    """psi and Var(w) of the link agent-intruder k: from the held message and the agent's own solution."""
    ranging, tick_s = params.ranging, params.clock.tick_s
    contact = before.contact[row, k]
    if not (contact["warning"] and contact["valid"]) or params.interface.track == "range":
        return 0.0, ranging.process_noise_m2
    r = contact["position_m"] - now.solution[row, 0]
    v = contact["velocity_mps"] - now.solution_mps[row, 0]
    d = np.linalg.norm(r)
    radial = r @ v / d
    angle = min(math.hypot(contact["std_m"], before.solution_std[row, 0]) / d, 1.0)
    across = v @ v - radial**2 + v @ v * angle**2
    noise = ranging.process_noise_psi_m2 + ranging.bearing_inflation * across * (angle * tick_s) ** 2
    return radial * tick_s, min(noise, ranging.process_noise_m2)


def radio(params, key, frames, row, k):
    """RSS of every tick (None where nothing is received), with the true coloured noise and path loss factor."""
    channel, g = params.channels[0], global_link(params.encounter.intruders, k)
    stream = STREAM_START_LINK + 10 + g
    a = math.exp(-params.clock.tick_s / channel.coloured_tc_s)
    slow = math.exp(-params.clock.decision_s / channel.path_loss_wander_tc_s)
    coloured = math.sqrt(channel.coloured_variance_db2) * normal(key, stream, 0)
    wander = channel.path_loss_wander * normal(key, stream, 1)
    for n, frame in enumerate(frames):
        coloured = a * coloured + math.sqrt(channel.coloured_variance_db2 * (1.0 - a * a)) * normal(
            key, STREAM_TICK + 2 * g, n
        )
        if n > 0:
            drive = channel.path_loss_wander * math.sqrt(1.0 - slow * slow)
            wander = slow * wander + drive * normal(key, STREAM_WANDER + g, n - 1)
        np.testing.assert_allclose(frame.link[row, k]["coloured_db"], coloured, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(frame.link[row, k]["wander"], wander, rtol=1e-10, atol=1e-10)
        d = np.linalg.norm(frame.position[row, 0] - frame.position[row, 1 + k])
        rss = channel.offset_dbm - 10.0 * (channel.path_loss_factor + wander) * np.log10(max(d, 0.1)) + coloured
        rss += math.sqrt(channel.white_variance_db2) * normal(key, STREAM_TICK + 2 * g + 1, n)
        if channel.quantisation_db > 0.0:
            rss = math.floor(rss / channel.quantisation_db + 0.5) * channel.quantisation_db
        heard = rss >= channel.sensitivity_dbm
        if channel.packet_loss > 0.0:
            heard = heard and uniform(key, STREAM_LOSS + g, n) >= channel.packet_loss
        yield rss, heard


def first(params, rss, s, r):
    """State and covariance after the first sample: a linear Kalman filter on [ln d, phi]."""
    channel, ranging = params.channels[0], params.ranging
    kf = KalmanFilter(dim_x=2, dim_z=1)
    kf.x = np.array([math.log(ranging.prior_range_m), 0.0])
    kf.P = np.diag([(ranging.prior_std_m / ranging.prior_range_m) ** 2, s])
    kf.H, kf.R = np.array([[-10.0 * channel.path_loss_factor / math.log(10.0), 1.0]]), np.array([[r]])
    kf.update(np.array([rss - channel.offset_dbm]))
    d = math.exp(kf.x[0])
    return np.array([d, kf.x[1]]), np.diag([d, 1.0]) @ kf.P @ np.diag([d, 1.0])


def replay(params, key, frames, row, k):
    """Filterpy's EKF over the episode: yields state and covariance of every tick.

    The filter that takes all noise as white is the same with S = 0, and S added to R.
    """
    channel, floor = params.channels[0], params.ranging.range_floor_m
    s = channel.coloured_variance_db2
    r = channel.white_variance_db2 + channel.quantisation_db**2 / 12.0
    if params.ranging.estimator == "ekf-white":
        s, r = 0.0, r + s
    a = math.exp(-params.clock.tick_s / channel.coloured_tc_s)
    offset, gamma = channel.offset_dbm, channel.path_loss_factor
    ekf = ExtendedKalmanFilter(dim_x=2, dim_z=1)
    ekf.F, ekf.B, ekf.R = np.diag([1.0, a]), np.array([1.0, 0.0]), np.array([[r]])
    for n, (rss, heard) in enumerate(radio(params, key, frames, row, k)):
        if n == 0:
            ekf.x, ekf.P = first(params, rss, s, r)
        else:
            psi, noise = closing(params, frames[n - 1], frames[n], row, k)
            ekf.Q = np.diag([noise, s * (1.0 - a * a)])
            ekf.predict(u=psi)
            ekf.x[0] = max(ekf.x[0], floor)
            if heard:
                ekf.update(
                    np.array([rss]),
                    lambda x: np.array([[-10.0 * gamma / (x[0] * np.log(10.0)), 1.0]]),
                    lambda x: np.array([offset - 10.0 * gamma * np.log10(x[0]) + x[1]]),
                )
                ekf.x[0] = max(ekf.x[0], floor)
        yield ekf.x, ekf.P


@pytest.mark.parametrize("name", WORLDS)
def test_in_world_filter_is_filterpys(name):
    params = Params.of(decision_s=0.1, **WORLDS[name])
    batch, frames = record(params, 100 + list(WORLDS).index(name))
    with_message = 0
    for row in range(ROWS):
        flown = [frame for n, frame in enumerate(frames) if n == 0 or not frames[n - 1].done[row]]
        assert len(flown) == batch.episode[row]["tick"] + 1
        for k in range(params.encounter.intruders):
            key = np.uint64(batch.episode[row]["key"])
            for frame, (x, p) in zip(flown, replay(params, key, flown, row, k), strict=True):
                link = frame.link[row, k]
                state = [link["range_m"], link["coloured_hat_db"]]
                covariance = [[link["p_dd"], link["p_dp"]], [link["p_dp"], link["p_pp"]]]
                np.testing.assert_allclose(state, x, rtol=1e-9, atol=1e-9)
                np.testing.assert_allclose(covariance, p, rtol=1e-9, atol=1e-9)
                with_message += frame.contact[row, k]["valid"] and frame.contact[row, k]["warning"]
    assert with_message > 300  # psi was in use, or on track `range` deliberately not
