"""Estimators of range over a batch of records beside filterpy, and how honest their variances are.

Run it as python benchmarks/ranging.py
"""

import math
import time

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from rss_gym.params import Channel, load_channel
from rss_gym.ranging import ESTIMATORS
from rss_gym.ranging.track import Tuning, track

RECORDS, SAMPLES, ROUNDS, FILTERPY_SAMPLES = 1000, 1000, 5, 5000
INTERVAL_S, AIM = 0.1, 10_000_000
NEES_RECORDS, NEES_SAMPLES = 200, 300


def noise(rng: np.random.Generator, shape: tuple[int, int], channel: Channel) -> tuple[np.ndarray, np.ndarray]:
    """Coloured noise (k, n) of (8), stationary from the start, and its sum with white noise."""
    a = math.exp(-INTERVAL_S / channel.coloured_tc_s)
    out = math.sqrt(channel.coloured_variance_db2) * rng.standard_normal(shape)
    for n in range(1, shape[1]):
        out[:, n] = a * out[:, n - 1] + math.sqrt(1.0 - a * a) * out[:, n]
    return out, out + math.sqrt(channel.white_variance_db2) * rng.standard_normal(shape)


def flights(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Ranges of straight encounters, closing at 2-8 m/s from 130-190 m with a miss of up to 60 m. Shape (k, n)."""
    start, speed = rng.uniform(130.0, 190.0, (shape[0], 1)), rng.uniform(2.0, 8.0, (shape[0], 1))
    return np.hypot(start - speed * INTERVAL_S * np.arange(shape[1]), rng.uniform(1.0, 60.0, (shape[0], 1)))


def walks(rng: np.random.Generator, shape: tuple[int, int], tuning: Tuning, logarithmic: bool) -> np.ndarray:
    """Ranges of the filter's own model: prior and random walk, in d (reflected at its floor) or in ln d."""
    steps = rng.standard_normal(shape)
    if logarithmic:
        steps[:, 0] *= tuning.prior_std_m / tuning.prior_range_m
        steps[:, 1:] *= math.sqrt(tuning.relative_noise_ps * INTERVAL_S)
        return tuning.prior_range_m * np.exp(np.cumsum(steps, axis=1))
    steps[:, 0] *= tuning.prior_std_m
    steps[:, 1:] *= math.sqrt(tuning.process_noise_m2_ps * INTERVAL_S)
    return np.maximum(np.abs(tuning.prior_range_m + np.cumsum(steps, axis=1)), tuning.range_floor_m)


def received(distance_m: np.ndarray, noise_db: np.ndarray, channel: Channel) -> np.ndarray:
    """(2)."""
    return channel.offset_dbm - 10.0 * channel.path_loss_factor * np.log10(distance_m) + noise_db


def filterpy_rate(rss_dbm: np.ndarray, channel: Channel) -> float:
    """Updates per CPU second of filterpy's EKF, two states, one record."""
    a = math.exp(-INTERVAL_S / channel.coloured_tc_s)
    ekf = ExtendedKalmanFilter(dim_x=2, dim_z=1)
    ekf.x, ekf.P = np.array([160.0, 0.0]), np.diag([3600.0, channel.coloured_variance_db2])
    ekf.F, ekf.R = np.diag([1.0, a]), np.array([[channel.white_variance_db2]])
    ekf.Q = np.diag([16.0, channel.coloured_variance_db2 * (1.0 - a * a)])
    slope, offset = 10.0 * channel.path_loss_factor, channel.offset_dbm
    start = time.process_time()
    for sample in rss_dbm:
        ekf.predict()
        ekf.update(
            np.array([sample]),
            lambda x: np.array([[-slope / (x[0] * math.log(10.0)), 1.0]]),
            lambda x: np.array([offset - slope * math.log10(x[0]) + x[1]]),
        )
    return len(rss_dbm) / (time.process_time() - start)


def speed(channel: Channel) -> None:
    """Print the rates, the ratio to filterpy in the same run, and whether the aim is met."""
    rng = np.random.default_rng(0)
    distance = flights(rng, (RECORDS, SAMPLES))
    rss = received(distance, noise(rng, distance.shape, channel)[1], channel)
    times = np.arange(SAMPLES) * INTERVAL_S
    theirs = max(filterpy_rate(rss.ravel()[:FILTERPY_SAMPLES], channel) for _ in range(ROUNDS))
    print(
        f"{RECORDS} records x {SAMPLES} regular samples, per CPU second, best of {ROUNDS}; filterpy's EKF {theirs:,.0f}"
    )
    rates = {}
    for name in ESTIMATORS:
        track(name, times, rss[:2], channel)  # compiles
        best = math.inf
        for _ in range(ROUNDS):
            start = time.process_time()
            track(name, times, rss, channel)
            best = min(best, time.process_time() - start)
        rates[name] = rss.size / best
        print(f"  {name:<22} {rates[name]:>12,.0f} samples, {rates[name] / theirs:>7,.0f} times filterpy's")
    aim = rates["ekf-coloured"]
    print(f"EKF updates per CPU second: {aim:,.0f} against {AIM:,}: {'met' if aim >= AIM else 'MISSED'}")


def consistency(channel: Channel) -> None:
    """Print NEES of both states, NIS and the error of the range, on encounters and on each filter's own model."""
    tuning, times = Tuning(), np.arange(NEES_SAMPLES) * INTERVAL_S
    print(f"{NEES_RECORDS} records x {NEES_SAMPLES}, seed 1; consistent: NEES of both states 2 (median 1.39), NIS 1")
    for truth in ("flights", "random walk"):
        for name in ("ekf-coloured", "ekf-coloured-literal", "ekf-log"):
            rng, shape = np.random.default_rng(1), (NEES_RECORDS, NEES_SAMPLES)
            logarithmic = ESTIMATORS[name].logarithmic
            distance = flights(rng, shape) if truth == "flights" else walks(rng, shape, tuning, logarithmic)
            coloured, total = noise(rng, shape, channel)
            out = track(name, times, received(distance, total, channel), channel, tuning)
            nees, error = out.nees(distance, coloured), np.abs(out.range_m - distance)
            nis = np.nanmean(out.nis)
            print(
                f"  {truth:<12} {name:<22} NEES {nees.mean():>6.2f} (median {np.median(nees):.2f})  NIS {nis:.2f}",
                end="",
            )
            print(f"  80 % of |range error| {np.quantile(error, 0.8):.1f} m")


def main() -> None:
    """Speed, then consistency, on the channel `paper`."""
    channel = load_channel("paper")
    speed(channel)
    consistency(channel)


if __name__ == "__main__":
    main()
