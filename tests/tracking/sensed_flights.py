"""Made-up flights of two aircraft and what one of them senses, for all tests of trackers: NumPy only."""

import numpy as np

from rss_gym.params import Params
from rss_gym.sensed import OTHER, OWN
from rss_gym.tracking import TRACK, memory_columns, model

STEP_S = 0.5


def tracker_model(**changes):
    """The model of a plane in which both sides are localised by radio, unless changed."""
    steady = {"agent": "rss", "intruder": "rss", "node_square_m": 300.0, "channel": {"path_loss_wander": 0.0}}
    return model(Params.of(**{**steady, **changes}))[0]


def records(**fields):
    """One OWN and one OTHER record of a plausible decision; fields of both by name, `own_` before those of OWN."""
    own, other = np.zeros(1, OWN)[0], np.zeros(1, OTHER)[0]
    own["velocity_mps"], own["std_m"] = (3.0, 0.0, 0.0), 6.0
    other["present"] = other["valid"] = other["warning"] = True
    other["range_m"], other["range_std_m"] = 80.0, 6.0
    other["position_m"], other["velocity_mps"], other["std_m"] = (78.0, 10.0, 0.0), (-3.0, 0.4, 0.0), 7.0
    other["path_loss_factor"], other["white_std_db"] = 2.7, 0.3
    other["coloured_std_db"], other["coloured_tc_s"] = 2.5, 0.15
    for name, value in fields.items():
        record, key = (own, name[4:]) if name.startswith("own_") else (other, name)
        record[key] = value
    return own, other


def empty(tracker):
    """Memory and track of one intruder."""
    return np.zeros(memory_columns(tracker)), np.zeros(1, TRACK)[0]


def errors(rng, count, steps, std, tc_s):
    """Gauss-Markov errors, stationary, shape (steps, count)."""
    a, out = np.exp(-STEP_S / tc_s), np.empty((steps, count))
    out[0] = std * rng.normal(size=count)
    for n in range(1, steps):
        out[n] = a * out[n - 1] + std * np.sqrt(1 - a * a) * rng.normal(size=count)
    return out


def flights(rng, count, steps, std_m, range_std_m, turning=False):
    """True relative positions (steps, count, 2), and OWN and OTHER records (steps, count) of what is sensed.

    The intruder passes at some metres after twenty seconds. Fixes err for seven seconds, the range for two.
    """
    time = STEP_S * np.arange(steps)[:, None]
    heading, miss = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(-15.0, 15.0, count)
    speed = rng.uniform(4.0, 7.0, count)
    way = speed * (time - 20.0)
    vx, vy = np.cos(heading) * speed * np.ones_like(way), np.sin(heading) * speed * np.ones_like(way)
    x = np.cos(heading) * way - np.sin(heading) * miss
    y = np.sin(heading) * way + np.cos(heading) * miss
    if turning:  # the agent flies a slow weave
        phase = rng.uniform(0.0, 2.0 * np.pi, count)
        x, vx = x - 12.0 * np.sin(0.25 * time + phase), vx - 3.0 * np.cos(0.25 * time + phase)
    own, other = np.zeros((steps, count), OWN), np.zeros((steps, count), OTHER)
    for axis, (p, v) in enumerate(((x, vx), (y, vy))):
        own["position_m"][..., axis] = errors(rng, count, steps, std_m, 7.0)
        other["position_m"][..., axis] = p + errors(rng, count, steps, std_m, 7.0)
        own["velocity_mps"][..., axis] = errors(rng, count, steps, 0.2, 60.0)
        other["velocity_mps"][..., axis] = v + errors(rng, count, steps, 0.2, 60.0)
    own["std_m"] = other["std_m"] = std_m
    share = errors(rng, count, steps, 1.0, 2.0)
    d = np.hypot(x, y)
    other["range_std_m"] = range_std_m * np.maximum(d, 35.0) / 60.0
    other["range_m"] = np.maximum(d + share * other["range_std_m"], 0.3)
    other["present"] = other["valid"] = other["warning"] = True
    other["path_loss_factor"], other["white_std_db"] = 2.7, 0.3
    other["coloured_std_db"], other["coloured_tc_s"] = 2.5, 0.15
    return np.stack([x, y], axis=-1), own, other


def fly(module, tracker, own, other, constants):
    """Tracks (steps, count) of a tracker over such records."""
    tracks = np.zeros(own.shape, TRACK)
    memory = np.zeros((own.shape[1], memory_columns(tracker)))
    for n in range(own.shape[0]):
        for i in range(own.shape[1]):
            module.advance(own[n, i], other[n, i], memory[i], tracks[n, i], constants)
    return tracks


def standardised(tracks, truth):
    """Errors of the track over their standard deviations, along and across the bearing of the track, and the errors."""
    p = tracks["position_m"][..., :2]
    n = p / np.maximum(np.linalg.norm(p, axis=-1, keepdims=True), 1e-9)
    right = np.stack([-n[..., 1], n[..., 0]], axis=-1)
    cov = np.stack([np.stack([tracks["xx"], tracks["xy"]], -1), np.stack([tracks["xy"], tracks["yy"]], -1)], -2)
    error = p - truth

    def over(axis):
        variance = np.einsum("...i,...ij,...j->...", axis, cov, axis)
        return np.sum(error * axis, axis=-1) / np.sqrt(variance)

    return over(n), over(right), np.linalg.norm(error, axis=-1)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
