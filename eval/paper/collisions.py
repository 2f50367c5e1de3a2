"""Figure 12: how often the safety zone fails, by formula, by the paper's counting, and flown."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from rss_gym.eval.intervals import clopper_pearson
from rss_gym.eval.paper.flights import PERIOD_S
from rss_gym.eval.paper.number import Number, exact
from rss_gym.eval.paper.panel import BLUE, GREEN, ORANGE, Panel
from rss_gym.eval.paper.study import Study
from rss_gym.eval.paper.zone import BOUND, ERRORS_M, PROBABILITY, REACTION_S, SPEED_MPS, ZONE, ZONES_M
from rss_gym.pages.figure import MUTED, figure
from rss_gym.radio import GaussMarkov, simulate
from rss_gym.ranging.track import track
from rss_gym.safety import miss_probability, miss_probability_correlated, radius_m
from rss_gym.safety.counting import count_missed

SIMULATED_M = {4.0: 115.0, 16.0: 230.0}  # where the paper's figure has 1e-5
READ_LOG = 0.5  # the figure has a logarithmic axis: half of a value
START_M = 300.0
FIRST_RECORD = 2**40  # far from those of the twelve flights
BATCH = 4000  # approaches at a time
RADII_M = np.arange(10.0, 241.0, 2.5)
LEAST_SHOWN = 1e-7

Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Approaches:
    """Head-on approaches under the world's filter."""

    late: Counts  # for each of `RADII_M`: the first warning comes later than t_r before contact
    silent: int  # the first n_d looks inside S all say safe
    entry_error_m: float  # within which 80 % of the estimates at the edge of S lie


def collisions(study: Study) -> Panel:
    """Figure 12."""
    counted = {delta: _counted(study, delta, key) for key, delta in enumerate(ERRORS_M)}
    flown, n = _approaches(study), study.size.approaches
    shares = [clopper_pearson(int(k), n) for k in flown.late]
    shown = [radius for radius, share in zip(RADII_M, shares, strict=True) if (share.high or 0.0) <= BOUND]
    covered = float(shown[0]) if shown else None
    at_zone = int(np.searchsorted(RADII_M, ZONE.radius_m))
    kept = GaussMarkov(1.0, study.channel.coloured_tc_s).decay(PERIOD_S)
    correlated = float(miss_probability_correlated(PROBABILITY, ZONE.trials, kept))
    numbers = (
        *(
            _by_counting(study, delta, counted[delta], radii[delta])
            for radii in (SIMULATED_M, ZONES_M)
            for delta in ERRORS_M
        ),
        Number(
            id="fig12-flown",
            what=f"flown: first warning later than {REACTION_S:g} s before contact, S = {ZONE.radius_m:g} m",
            paper=BOUND,
            seen=shares[at_zone],
            role="claim",
            relation="at most",
            note=f"{flown.late[at_zone]} of {n:,} approaches at {SPEED_MPS:g} m/s from {START_M:g} m under the world's "
            "filter on the preset paper" + ("" if covered is not None else "; too few to show it"),
        ),
        *(
            Number(
                id="fig12-covers",
                what="flown: least radius whose miss probability is at most 1e-5 (upper end of 95 %)",
                paper=ZONE.radius_m,
                seen=exact(float(radius), n),
                unit="m",
                role="claim",
                relation="at most",
                note="the radius of (40) covers it by far: near contact the RSS is above what noise can hide",
            )
            for radius in shown[:1]  # too few approaches show none
        ),
        Number(
            id="fig12-looks",
            what=f"flown: the first {ZONE.trials} looks inside S = {ZONE.radius_m:g} m, at 10 Hz, all say safe",
            paper=float(miss_probability(PROBABILITY, ZONE.trials)),
            seen=clopper_pearson(flown.silent, n),
            role="claim",
            relation="at most",
            note="(36) takes the looks as independent and 80 % of them as within 4 m. Here successive errors are "
            "nearly the same, as noise and filter remember for seconds, and 80 % are within "
            f"{flown.entry_error_m:.0f} m at the edge of the zone; without velocity the filter also lags behind an "
            "approach. Even normal errors within 4 m at 80 %, correlated as the channel's noise, would all miss with "
            f"probability {correlated:.2g}. Many more looks follow: these make the radius safe",
        ),
    )
    return Panel(
        "Figure 12: collisions and radius",
        _drawing(study, counted, np.array([share[:3] for share in shares], dtype=np.float64)),
        "The collision probability falls with the radius: 1e-5 at 115 m (errors of 4 m) and 230 m (16 m), just below "
        "the 120 m and 240 m of (40).",
        "Counted as in the paper it follows (36), by construction. Flown with the filter's own errors it falls faster, "
        + ("though too few are flown to show how far" if covered is None else f"to below 1e-5 from {covered:g} m on")
        + f"; the first {ZONE.trials} looks inside {ZONE.radius_m:g} m all miss in {100.0 * flown.silent / n:.0f} % "
        "of the approaches.",
        numbers,
    )


def _drawing(study: Study, counted: dict[float, Counts], shares: NDArray[np.float64]) -> Markup:
    """`shares` (radii, 3): value, low and high."""
    with figure("Miss probability over the radius of the zone", height_in=4.4) as drawing:
        axes = drawing.axes
        for delta, colour in zip(ERRORS_M, (BLUE, ORANGE), strict=True):
            step = _step_m(delta)
            axes.plot(RADII_M, (1.0 - PROBABILITY) ** (RADII_M / step), color=colour, label=f"(36), {delta:g} m")
            looks = np.flatnonzero(counted[delta])[1:]
            value, low, high = np.array(
                [clopper_pearson(int(k), study.size.trials)[:3] for k in counted[delta][looks]]
            ).T
            axes.errorbar(
                step * looks, value, (value - low, high - value), fmt="o", color=colour, markersize=4.0,
                label=f"the paper's counting, {delta:g} m",
            )  # fmt: skip
        value, low, high = shares.T
        axes.fill_between(RADII_M, np.maximum(low, 0.1 * LEAST_SHOWN), high, color=GREEN, alpha=0.25, linewidth=0.0)
        axes.plot(
            RADII_M[value > 0.0], value[value > 0.0], color=GREEN, marker=".", label="flown, preset paper (band: 95 %)"
        )
        axes.axhline(BOUND, color=MUTED, linewidth=0.8, linestyle=":")
        axes.set(yscale="log", xlim=(0.0, 245.0), ylim=(LEAST_SHOWN, 1.5))
        axes.set(xlabel="radius of the safety zone, m", ylabel="probability of a miss")
        axes.legend(loc="upper right")
    return drawing.html


def _step_m(delta_m: float) -> float:
    """The way that (40) has for each look."""
    return float(radius_m(delta_m, PROBABILITY, SPEED_MPS, REACTION_S, 1))


def _counted(study: Study, delta_m: float, key: int) -> Counts:
    """Trials whose first n looks all err, n = 0, 1, ..., up to as many as the largest radius has room for."""
    looks = ceil(RADII_M[-1] / _step_m(delta_m))
    return count_missed(PROBABILITY, looks, study.size.trials, key=2 * study.seed + key)


def _by_counting(study: Study, delta_m: float, counted: Counts, radius: float) -> Number:
    """The paper's counting: as many looks as the radius has room for, and a miss if all of them err."""
    n, simulated = int(radius / _step_m(delta_m) + 1e-9), radius == SIMULATED_M[delta_m]
    return Number(
        id=f"fig12-counted-{radius:g}",
        what=f"counted: all looks within {radius:g} m err by more than {delta_m:g} m",
        paper=BOUND,
        seen=clopper_pearson(int(counted[n]), study.size.trials),
        role="by construction",
        relation="equals" if simulated else "at most",
        tolerance=READ_LOG * BOUND if simulated else 0.0,
        note=f"{n} looks, 0.2^{n} = {(1.0 - PROBABILITY) ** n:.3g}; {study.size.trials:,} trials",
    )


def _approaches(study: Study) -> Approaches:
    contact_m = ZONE.collision_m
    distance = np.arange(START_M, contact_m, -SPEED_MPS * PERIOD_S)
    in_time = distance >= contact_m + SPEED_MPS * REACTION_S
    entry = int(np.argmax(distance <= ZONE.radius_m))
    late, silent, errors = np.zeros(len(RADII_M), np.int64), 0, []
    for first in range(0, study.size.approaches, BATCH):
        rows = np.broadcast_to(distance, (min(BATCH, study.size.approaches - first), len(distance)))
        log = simulate(rows, PERIOD_S, study.channel, study.seed, FIRST_RECORD + first)
        estimate = track("ekf-coloured", log.time_s, log.rss_dbm, study.channel).range_m
        lowest = estimate[:, in_time].min(axis=1)  # a warning is in time if this is at most the radius
        late += np.sum(lowest[:, None] > RADII_M, axis=0)
        silent += int(np.sum((estimate[:, entry : entry + ZONE.trials] > ZONE.radius_m).all(axis=1)))
        errors.append(np.abs(estimate[:, entry] - distance[entry]))
    return Approaches(late, silent, float(np.quantile(np.concatenate(errors), 0.8)))
