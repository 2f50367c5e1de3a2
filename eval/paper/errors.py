"""Figures 5 and 10, 8, 9: least squares against the Kalman filter on the twelve flights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rss_gym.eval.paper.flights import PERIOD_S
from rss_gym.eval.paper.number import MIDDLE, Number, over
from rss_gym.eval.paper.panel import BLUE, GREEN, ORANGE, RED, Panel, draw_cdf, finish_cdf
from rss_gym.eval.paper.signal import SHOWN
from rss_gym.eval.paper.study import METHODS, Study
from rss_gym.pages.figure import MUTED, figure
from rss_gym.physics.path_loss import LN10

READ = 0.1  # a figure read off a curve, "about 4 m", may be misread by a tenth
BINS_M = np.arange(10.0, 60.0, 5.0)
NEAR_M, FAR_M = (10.0, 25.0), (45.0, 60.0)
MARK_S = 4.0  # between the samples marked on a path


def cdf(study: Study) -> Panel:
    """Figures 5 and 10."""
    least, kalman = study.p80_m("ls"), study.p80_m("coloured")
    with figure("Distribution of the range errors of least squares and of the Kalman filter") as drawing:
        for name, colour, style in (("ls", ORANGE, "-"), ("ls-window", GREEN, "--"), ("coloured", BLUE, "-")):
            draw_cdf(drawing.axes, study.errors_m(name), METHODS[name].label, colour, style)
        finish_cdf(drawing.axes, 30.0)
    runs = f"{study.size.repetitions} repetitions of the twelve flights"
    numbers = (
        Number(
            id="fig10-ls",
            what="error of least squares, 80 %",
            paper=10.0,
            seen=over(least),
            unit="m",
            role="calibrated",
            tolerance=READ * 10.0,
            note=f"the total noise of the preset paper, 6.5 dB², was chosen to give this; {runs}",
        ),
        Number(
            id="fig10-ekf",
            what="error of the coloured Kalman filter, 80 %",
            paper=4.0,
            seen=over(kalman),
            unit="m",
            role="reproduced",
            tolerance=READ * 4.0,
            note="without velocity the RSS alone cannot tell coloured noise from a change of range: 1 dB is "
            f"{10.0 * LN10 / study.channel.path_loss_factor:.1f} % of the range, and the noise stays for "
            f"{study.channel.coloured_tc_s:g} s; Var(w) {study.noise_m2_ps('coloured'):.3g} m²/s; {runs}",
        ),
        Number(
            id="fig10-gain",
            what="error of least squares over that of the coloured Kalman filter, 80 %",
            paper=2.5,
            seen=over(least / kalman),
            role="reproduced",
            tolerance=2.0 * READ * 2.5,
            note="both figures of the ratio may be misread by a tenth; the filter is better in "
            f"{100.0 * np.mean(kalman < least):.0f} % of {runs}",
        ),
    )
    return Panel(
        "Figures 5 and 10: error distribution",
        drawing.html,
        "80 % of the errors are within about 4 m with the Kalman filter and within about 10 m with least squares.",
        f"80 % are within {np.median(kalman):.1f} m and {np.median(least):.1f} m; the mean of a 5 s window, a second "
        f"reading of least squares, gives {np.median(study.p80_m('ls-window')):.1f} m.",
        numbers,
    )


def paths(study: Study) -> Panel:
    """Figure 8."""
    flights = study.flown.flights
    every = round(MARK_S / PERIOD_S)
    with figure("The flights from above and from the side", columns=2, height_in=3.6) as drawing:
        above, side = drawing.axes
        for number, flight in enumerate(flights):
            north, east, up = flight.position_m.T
            out = np.hypot(north, east)
            for axes, x, y in ((above, east, north), (side, out, up)):
                axes.plot(x, y, color=BLUE, linewidth=1.0, label=None if number else "flight")
                axes.plot(
                    x[::every],
                    y[::every],
                    "*",
                    color=RED,
                    markersize=4.0,
                    label=None if number else f"RSS, every {MARK_S:g} s",
                )
        above.plot([0.0], [0.0], "^", color=MUTED, markersize=7.0, label="ground antenna")
        side.plot([0.0], [0.0], "^", color=MUTED, markersize=7.0, clip_on=False)
        above.set(xlabel="east, m", ylabel="north, m", xlim=(-70.0, 70.0), ylim=(-70.0, 70.0), aspect="equal")
        side.set(
            xlabel="horizontal distance from the antenna, m", ylabel="height, m", xlim=(0.0, 70.0), ylim=(0.0, 45.0)
        )
        side.legend(*above.get_legend_handles_labels(), loc="upper right")
    samples = sum(len(flight.time_s) for flight in flights)
    return Panel(
        "Figure 8: flights",
        drawing.html,
        "Flights out from a ground antenna and back within 60 m, in four directions at three altitudes, at 0 to 5 m/s.",
        f"Twelve simulated flights of the same plan: {samples:,} samples at {1.0 / PERIOD_S:g} Hz up to "
        f"{max(flight.distance_m.max() for flight in flights):.0f} m and "
        f"{max(f.speed_mps.max() for f in flights):.0f} m/s. The paper's own flights are not published.",
    )


def distance(study: Study) -> Panel:
    """Figure 9."""
    flight, log = study.flown.flights[SHOWN], study.flown.logs[SHOWN]
    true_m = np.concatenate([one.distance_m for one in study.flown.flights])
    with figure("Estimated distance over time, and errors over distance", columns=2, height_in=3.6) as drawing:
        left, right = drawing.axes
        for offset, (name, colour) in zip((-0.5, 0.5), (("ls", ORANGE), ("coloured", BLUE)), strict=True):
            label = "least squares" if name == "ls" else "Kalman filter"
            ranges = study.flown.ranges_m(METHODS[name], study.channel, study.noise_m2_ps(name))[SHOWN][0]
            left.plot(log.time_s, ranges, color=colour, linewidth=0.7 if name == "ls" else 1.4, label=label)
            binned = np.array([_p80_m(study.errors_m(name), true_m, low, low + 5.0) for low in BINS_M])
            low, middle, high = np.quantile(binned, (MIDDLE[0], 0.5, MIDDLE[1]), axis=1)
            right.errorbar(
                BINS_M + 2.5 + offset,
                middle,
                [middle - low, high - middle],
                color=colour,
                marker="o",
                markersize=3.0,
                elinewidth=0.8,
                label=label,
            )
        left.plot(log.time_s, flight.distance_m, color=MUTED, linestyle="--", label="true")
        left.set(xlabel="time, s", ylabel="distance, m", xlim=(0.0, log.time_s[-1]), ylim=(0.0, 190.0))
        right.set(
            xlabel="true distance, m", ylabel="error within which 80 % lie, m", xlim=(8.0, 62.0), ylim=(0.0, None)
        )
        left.legend(loc="upper left", ncols=2)
        right.legend(loc="upper left")
    numbers = tuple(
        Number(
            id=f"fig9-growth-{name}",
            what=f"error at 45 to 60 m over that at 10 to 25 m, 80 %: {METHODS[name].label}",
            paper=1.0,
            seen=over(_p80_m(study.errors_m(name), true_m, *FAR_M) / _p80_m(study.errors_m(name), true_m, *NEAR_M)),
            role="claim",
            relation="at least",
            note=f"an error in dB is a share of the range; {study.size.repetitions} repetitions",
        )
        for name in ("ls", "coloured")
    )
    return Panel(
        "Figure 9: distance",
        drawing.html,
        "Least squares fluctuates severely, the Kalman filter is more stable, and both err more at larger distances.",
        f"One repetition of the flight {flight.name} (left), and the errors of all flights over the distance (right; "
        f"bars: middle 95 % of {study.size.repetitions} repetitions). From near to far the error grows "
        f"{numbers[0].measured:.1f} times with least squares, {numbers[1].measured:.1f} times with the filter.",
        numbers,
    )


def _p80_m(
    errors_m: NDArray[np.float64], true_m: NDArray[np.float64], low_m: float, high_m: float
) -> NDArray[np.float64]:
    """(k,): error within which 80 % of the samples at true distances in [low, high) lie."""
    chosen = (true_m >= low_m) & (true_m < high_m)
    return np.quantile(errors_m[:, chosen], 0.8, axis=1)
