"""The data that several figures share: twelve flights flown many times, and the filters tuned on eight others."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from rss_gym.eval.paper.flights import PERIOD_S, PaperFlight, paper_flights, tuning_flights
from rss_gym.params import Channel, Group, Navigation, load_channel, number
from rss_gym.radio import RadioLog, simulate
from rss_gym.ranging.track import Tuning, track

Floats = NDArray[np.float64]

PRIOR_RANGE_M, PRIOR_STD_M = 30.0, 17.0  # all that is known before the first sample: within 60 m
NAVIGATION = Navigation()  # how the world errs in velocity
NOISE_GRID_M2_PS = 10.0 ** np.arange(-3.0, 3.01, 0.25)
RECORDS_APART = 2**20  # numbers of records that one flight may use


@dataclass(frozen=True, slots=True, kw_only=True)
class Size(Group):
    """How much is run."""

    repetitions: int = number(400, 2, 10_000)  # of the twelve flights
    tuning: int = number(40, 1, 10_000)  # of the eight
    circular: int = number(20, 1, 10_000)  # repetitions with gamma from the filter's own distances
    allan: int = number(40, 2, 1_000)  # records of an hour
    trials: int = number(100_000_000, 1000, 2**31)
    approaches: int = number(1_000_000, 100, 10**8)
    pairs: int = number(1_000, 10, 10**6)
    scan: int = number(20, 1, 1_000)  # repetitions of the twelve flights on each channel of the scan


QUICK = Size(repetitions=40, tuning=10, circular=4, allan=10, trials=2_000_000, approaches=20_000, pairs=200, scan=2)


@dataclass(frozen=True)
class Method:
    """A way to estimate the range; `estimator` is a name of `rss_gym.ranging.track.ESTIMATORS`."""

    label: str
    estimator: str
    velocity: bool = False
    tuned: Literal["", "noise", "rate"] = "noise"  # the process noise that is tuned: with or without velocity


METHODS: dict[str, Method] = {
    "ls": Method("least squares, each sample", "ls", tuned=""),
    "ls-window": Method("least squares, mean of 5 s", "ls-window", tuned=""),
    "white-r": Method("Kalman filter, white noise of variance R", "ekf-white-r"),
    "white": Method("Kalman filter, white noise of variance R + S", "ekf-white"),
    "coloured": Method("Kalman filter, coloured noise", "ekf-coloured"),
    "white-velocity": Method("white noise of variance R + S, with velocity", "ekf-white", True, "rate"),
    "coloured-velocity": Method("coloured noise, with velocity", "ekf-coloured", True, "rate"),
}


@dataclass(frozen=True)
class FlownLogs:
    """Flights with the radio logs and the measured range rates of k repetitions."""

    flights: tuple[PaperFlight, ...]
    logs: tuple[RadioLog, ...]  # (k, n) each
    range_rates_mps: tuple[Floats, ...]  # (k, n) each

    @classmethod
    def of(cls, flights: tuple[PaperFlight, ...], channel: Channel, repetitions: int, seed: int) -> FlownLogs:
        """Simulate the logs and the measured range rates of these flights, `repetitions` of each."""
        logs, rates = [], []
        for n, flight in enumerate(flights):
            distance = np.broadcast_to(flight.distance_m, (repetitions, len(flight.time_s)))
            logs.append(simulate(distance, PERIOD_S, channel, seed, RECORDS_APART * n))
            rates.append(_measured_rates(flight, repetitions, np.random.default_rng([seed, n])))
        return cls(flights, tuple(logs), tuple(rates))

    def errors_m(self, method: Method, channel: Channel, noise_m2_ps: float) -> Floats:
        """(k, samples of all flights): size of the range error."""
        return np.concatenate(
            [
                np.abs(ranges - log.distance_m)
                for ranges, log in zip(self.ranges_m(method, channel, noise_m2_ps), self.logs, strict=True)
            ],
            axis=1,
        )

    def ranges_m(self, method: Method, channel: Channel, noise_m2_ps: float) -> list[Floats]:
        """(k, n) for each flight."""
        tuning = tuning_of(noise_m2_ps)
        return [
            track(method.estimator, log.time_s, log.rss_dbm, channel, tuning, rate if method.velocity else None).range_m
            for log, rate in zip(self.logs, self.range_rates_mps, strict=True)
        ]


def tuning_of(noise_m2_ps: float) -> Tuning:
    """The filters' settings; Var(w) per second is one number, whether the velocity is known or not."""
    return Tuning(
        process_noise_m2_ps=noise_m2_ps,
        process_noise_rate_m2_ps=noise_m2_ps,
        prior_range_m=PRIOR_RANGE_M,
        prior_std_m=PRIOR_STD_M,
    )


class Study:
    """What the figures draw on, computed when first asked for; the same seed and size give the same numbers."""

    def __init__(self, size: Size, seed: int = 0, channel: Channel | str = "paper", pace: float = 1.0) -> None:
        """Keep the size and the seed, the channel, and the pace of the flights."""
        self.size, self.seed, self.pace = size, seed, pace
        self.channel = load_channel(channel)
        self._noise: dict[str, float] = {}
        self._errors: dict[str, Floats] = {}

    @cached_property
    def flown(self) -> FlownLogs:
        """The twelve flights."""
        return FlownLogs.of(paper_flights(self.pace), self.channel, self.size.repetitions, self.seed)

    @cached_property
    def others(self) -> FlownLogs:
        """The eight flights for tuning, under noise of their own."""
        return FlownLogs.of(tuning_flights(self.pace), self.channel, self.size.tuning, self.seed + 1)

    def noise_m2_ps(self, name: str) -> float:
        """Var(w) per second of a method: of the grid, what errs least at 80 % on the flights for tuning."""
        method = METHODS[name]
        if not method.tuned:
            return 1.0  # makes no use of it
        if name not in self._noise:
            found = [np.quantile(self.others.errors_m(method, self.channel, q), 0.8) for q in NOISE_GRID_M2_PS]
            self._noise[name] = float(NOISE_GRID_M2_PS[int(np.argmin(found))])
        return self._noise[name]

    def errors_m(self, name: str) -> Floats:
        """(k, samples): size of a method's range errors on the twelve flights."""
        if name not in self._errors:
            self._errors[name] = self.flown.errors_m(METHODS[name], self.channel, self.noise_m2_ps(name))
        return self._errors[name]

    def p80_untuned_m(self) -> Floats:
        """(k,): the same of the white filter with R alone and the process noise of the coloured one.

        "The other parameters were the same for both", says the paper.
        """
        errors = self.flown.errors_m(METHODS["white-r"], self.channel, self.noise_m2_ps("coloured"))
        return np.quantile(errors, 0.8, axis=1)

    def p80_m(self, name: str) -> Floats:
        """(k,): the error that 80 % of a repetition's samples stay within."""
        return np.quantile(self.errors_m(name), 0.8, axis=1)

    @cached_property
    def noise_floor_m2_ps(self) -> float:
        """2 Tv sigma_v^2 of the flights for tuning: the random walk that spreads as they do, once a leg is over.

        sigma_v is the standard deviation of the range rate, Tv the integral of its correlation up to the first zero.
        """
        products, variance, count = np.zeros(400), 0.0, 0
        for flight in self.others.flights:
            rate = flight.range_rate_mps
            variance, count = variance + float(rate @ rate), count + len(rate)
            products += [float(rate[: len(rate) - lag] @ rate[lag:]) for lag in range(len(products))]
        correlation = products / variance
        end = int(np.argmax(correlation <= 0.0)) or len(correlation)
        return 2.0 * float(correlation[:end].sum()) * PERIOD_S * variance / count


def _measured_rates(flight: PaperFlight, repetitions: int, random: np.random.Generator) -> Floats:
    """(k, n): range rates from velocities that err by a Gauss-Markov process on each axis (Sec. IX-D)."""
    a = float(np.exp(-PERIOD_S / NAVIGATION.dead_reckoning_tc_s))
    drive = random.standard_normal((repetitions, 3, len(flight.time_s)))
    drive[..., 1:] *= np.sqrt(1.0 - a * a)  # it starts stationary
    error = NAVIGATION.dead_reckoning_mps * lfilter([1.0], [1.0, -a], drive)
    return flight.range_rate_mps + np.einsum("kcn,nc->kn", error, flight.line_of_sight)
