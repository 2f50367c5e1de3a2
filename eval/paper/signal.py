"""Figures 2 and 3: a segment of the signal, and the Allan variance of its noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rss_gym.eval.paper.flights import PERIOD_S
from rss_gym.eval.paper.number import Number, over
from rss_gym.eval.paper.panel import BLUE, ORANGE, Panel
from rss_gym.eval.paper.study import Study
from rss_gym.pages.figure import MUTED, NOMINAL, figure
from rss_gym.pages.numbers import MINUS
from rss_gym.params import Channel, load_channel
from rss_gym.radio import AllanCurve, GaussMarkov, allan_curve, allan_model, received, simulate

SHOWN = 4  # of the twelve flights: north at 20 m
HOVER_M, RECORD_S = 30.0, 3600.0
SHORT_S = 10.0  # the paper's log tau < 1
LONG_S = 100.0  # and log tau > 2
COLOURED_MIN_DB2 = 1e-6  # the least that a channel takes


def segment(study: Study) -> Panel:
    """Figure 2."""
    flight, log = study.flown.flights[SHOWN], study.flown.logs[SHOWN]
    clean = received(flight.distance_m, study.channel)
    with figure("Received signal strength over one flight") as drawing:
        axes = drawing.axes
        axes.plot(log.time_s, log.rss_dbm[0], color=BLUE, linewidth=0.8, label="RSS")
        axes.plot(log.time_s, clean + log.coloured_db[0], color=ORANGE, label="path loss + coloured noise")
        axes.plot(log.time_s, clean, color=MUTED, linestyle="--", label="path loss (2)")
        axes.set(xlabel="time, s", ylabel="RSS, dBm", xlim=(0.0, log.time_s[-1]))
        axes.legend(loc="upper center", ncols=3)
    return Panel(
        "Figure 2: received signal",
        drawing.html,
        "One segment of the received signal, with slow and fast variations.",
        f"RSS at {1.0 / PERIOD_S:g} Hz over the flight {flight.name}, on the channel preset paper: the coloured noise "
        "wanders for seconds, the white noise jumps from sample to sample.",
    )


def allan(study: Study) -> Panel:
    """Figure 3."""
    paper, strong = study.channel, load_channel("quadcopter")
    total = paper.white_variance_db2 + paper.coloured_variance_db2
    white = paper.replace(
        white_variance_db2=total, coloured_variance_db2=COLOURED_MIN_DB2, path_loss_wander=0.0, quantisation_db=0.0
    )
    shown = {
        "white noise only": (white, NOMINAL),
        "preset paper": (paper, BLUE),
        "preset quadcopter (a real telemetry link)": (strong, ORANGE),
    }
    curves = {label: _curves(study, channel, 3 * k) for k, (label, (channel, _)) in enumerate(shown.items())}
    with figure("Allan variance over cluster length", height_in=3.8) as drawing:
        axes = drawing.axes
        for label, (channel, colour) in shown.items():
            curve = curves[label][0]
            low, high = curve.interval()
            axes.fill_between(curve.tau_s, low, high, color=colour, alpha=0.2, linewidth=0.0)
            axes.plot(curve.tau_s, curve.variance_db2, color=colour, marker="o", markersize=3.0, label=label)
            noise = GaussMarkov(channel.coloured_variance_db2, channel.coloured_tc_s)
            model = allan_model(curve.clusters, channel.white_variance_db2, noise, PERIOD_S)
            axes.plot(curve.tau_s, model, color=colour, linestyle=":", linewidth=1.0)
        axes.plot([], [], color=MUTED, linestyle=":", linewidth=1.0, label="white + Gauss-Markov, exact")
        axes.set(xscale="log", yscale="log", xlabel="cluster length τ, s", ylabel="Allan variance, dB²")
        axes.legend(loc="lower left")
    runs = f"{study.size.allan} records of an hour"
    slopes = {label: np.array([_slopes(curve) for curve in found]) for label, found in curves.items()}
    tau = curves["preset paper"][0].tau_s
    short = np.sqrt(tau[1:] * tau[:-1]) < SHORT_S
    at_long = int(np.searchsorted(tau, LONG_S))
    rises = {label: np.max(found[:, short], axis=1) for label, found in slopes.items()}
    white_at_long = allan_model(tau[at_long] / PERIOD_S, total, GaussMarkov(COLOURED_MIN_DB2, 1.0), PERIOD_S)
    excess = np.array([curve.variance_db2[at_long] for curve in curves["preset paper"]]) / white_at_long
    numbers = (
        Number(
            id="fig3-slope-white",
            what="slope of the Allan variance of white noise, both axes logarithmic",
            paper=-1.0,
            seen=over([_slope(curve) for curve in curves["white noise only"]]),
            role="reproduced",
            tolerance=0.02,
            note=f"least squares over τ < {SHORT_S:g} s; {runs}",
        ),
        Number(
            id="fig3-rise-paper",
            what=f"steepest slope at τ < {SHORT_S:g} s with coloured noise, preset paper",
            paper=0.0,
            seen=over(rises["preset paper"]),
            role="calibrated",
            relation="at least",
            note="the correlation time of the preset was chosen for a variance that is flat at short τ; "
            f"{_mix(paper)}; "
            f"{runs}",
        ),
        Number(
            id="fig3-rise-quadcopter",
            what=f"steepest slope at τ < {SHORT_S:g} s, preset quadcopter",
            paper=0.0,
            seen=over(rises["preset quadcopter (a real telemetry link)"]),
            role="claim",
            relation="at least",
            note=f"noise as fitted to a real link, {_mix(strong)}; {runs}",
        ),
        Number(
            id="fig3-long",
            what=f"Allan variance at τ = {tau[at_long]:.3g} s over that of white noise alone, preset paper",
            paper=1.0,
            seen=over(excess),
            role="claim",
            relation="at least",
            note=f"correlated noise shows beyond log τ = 2; {runs}",
        ),
    )
    return Panel(
        "Figure 3: Allan variance",
        drawing.html,
        "White noise falls with slope −1; the real signal rises at short τ and lies above white noise at long τ.",
        f"White noise falls with slope {MINUS}{abs(numbers[0].measured):.2f}. With coloured noise the steepest slope "
        f"at short τ is {numbers[1].measured:.2f} on the preset paper and {numbers[2].measured:.2f} with the noise of "
        "a real telemetry link. Bands are the 95 % intervals (5)-(6) of one record of an hour.",
        numbers,
    )


def _mix(channel: Channel) -> str:
    ratio = channel.coloured_variance_db2 / channel.white_variance_db2
    return f"coloured noise has {ratio:.3g} times the variance of white noise"


def _curves(study: Study, channel: Channel, first: int) -> list[AllanCurve]:
    hover = np.full((study.size.allan, round(RECORD_S / PERIOD_S)), HOVER_M)
    log = simulate(hover, PERIOD_S, channel, study.seed + 2 + first)
    return [allan_curve(rss, PERIOD_S) for rss in log.rss_dbm]


def _slopes(curve: AllanCurve) -> NDArray[np.float64]:
    return np.diff(np.log10(curve.variance_db2)) / np.diff(np.log10(curve.tau_s))


def _slope(curve: AllanCurve) -> float:
    short = curve.tau_s < SHORT_S
    return float(np.polyfit(np.log10(curve.tau_s[short]), np.log10(curve.variance_db2[short]), 1)[0])
