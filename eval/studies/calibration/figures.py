"""The figures of a calibration's page."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from markupsafe import Markup

from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats
from rss_gym.eval.studies.calibration.calibrate import Calibration
from rss_gym.eval.studies.calibration.compare import SHARES
from rss_gym.eval.studies.calibration.methods import RATE
from rss_gym.eval.studies.calibration.text import printable
from rss_gym.pages.colours import ESTIMATORS
from rss_gym.pages.figure import CLASSES, COLOURS, INK, MUTED, NOMINAL, figure
from rss_gym.radio import GaussMarkov, allan_model, received

LINKS_SHOWN = 12
_POINTS, _LINE = 250, 600  # samples drawn of a link, of a curve: the page stays small
_WIDTH_IN = 11.0
_BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5), "borderaxespad": 0.0}
# A method and the same with psi share a colour, the latter dashed.
METHOD_COLOURS = {"constant": NOMINAL} | {name: CLASSES[class_] for name, class_ in ESTIMATORS.items()}


def thinned(length: int, count: int) -> slice:
    """Every so manyth of `length` samples, at most about `count` of them."""
    return slice(None, None, max(1, math.ceil(length / count)))


def colour_of(name: str) -> str:
    """The colour of a method."""
    return METHOD_COLOURS.get(name.removesuffix(RATE), COLOURS[3])


def errors(result: Calibration) -> Markup:
    """Distribution of the absolute range error, a curve a method."""
    truth_m = np.concatenate([record.distance_m for record in result.tested])
    with figure(
        "Share of samples whose range error is below a limit, for each method", width_in=8.6, height_in=4.0
    ) as drawing:
        axes, ends = drawing.axes, []
        for name, method in result.methods.items():
            error_m = np.abs(np.concatenate(result.scores[name].ranges_m) - truth_m)
            share = np.linspace(0.0, 1.0, 201)
            limit_m = np.quantile(error_m, share)
            ends.append(limit_m[180])
            style = "--" if method.base is not None else ":" if method.estimator is None else "-"
            width = 2.4 if name == "ekf-coloured" else 1.4
            axes.plot(limit_m, share, style, color=colour_of(name), linewidth=width, label=method.title)
        axes.axhline(SHARES[1], color=MUTED, linewidth=0.8, linestyle=(0, (2, 3)))
        axes.set(xlim=(0.0, 1.1 * float(np.median(ends))), ylim=(0.0, 1.0))
        axes.set(xlabel="absolute range error, m", ylabel="share of samples")
        axes.legend(**_BESIDE)
    return drawing.html


def path_loss(result: Calibration) -> Markup:
    """RSS against distance, a panel a link, with the link's fit and the channel."""
    links = list(result.fit.links.items())[:LINKS_SHOWN]
    columns = min(4, len(links)) if len(links) % 3 else 3
    rows = math.ceil(len(links) / columns)
    width_in, height_in = (7.0, 3.8) if len(links) == 1 else (_WIDTH_IN, 0.6 + 1.9 * rows)
    everything_m = np.concatenate([link.distance_m for _, link in links])
    line_m = np.geomspace(everything_m.min(), everything_m.max(), 40)
    with figure(
        "RSS against distance with the fitted path loss of each link", rows, columns, width_in=width_in,
        height_in=height_in, sharex=True, sharey=True, squeeze=False,
    ) as drawing:  # fmt: skip
        panels = drawing.axes.ravel()
        for axes, (name, link) in zip(panels, links, strict=False):
            shown = thinned(link.rows, _POINTS)
            rss_dbm = np.concatenate([record.rss_dbm for record in link.records])
            axes.plot(link.distance_m[shown], rss_dbm[shown], ".", color=COLOURS[0], markersize=3.0, alpha=0.45)
            own_m = np.geomspace(link.distance_m.min(), link.distance_m.max(), 40)
            axes.plot(own_m, received(own_m, result.fit.channel_of(name)), color=COLOURS[1], linewidth=1.8)
            axes.plot(line_m, received(line_m, result.fit.channel), color=INK, linewidth=1.0, linestyle="--")
            fit = link.path_loss
            factor = f"γ = {fit.path_loss_factor:.2f} ± {1.96 * fit.path_loss_factor_std:.2f}"
            axes.set_title(f"{shortened(name)}: {factor}", loc="left")
            axes.set_xscale("log")
        for above, axes in zip(panels[len(links) - columns :], panels[len(links) :], strict=False):
            axes.set_visible(False)
            above.tick_params(labelbottom=True)
        _plain_logarithm(panels[0].xaxis, everything_m)
        canvas = panels[0].figure
        canvas.supxlabel("distance, m", color=MUTED, fontsize=9.0)
        canvas.supylabel("RSS, dBm", color=MUTED, fontsize=9.0)
        handles = panels[0].get_lines()
        canvas.legend(
            handles, ["samples", "fit of the link", "channel"], loc="outside upper right", ncols=3, markerscale=2.0
        )
    return drawing.html


def allan(result: Calibration) -> Markup:
    """The Allan variance of the residuals with its interval, and what the fitted noise should show."""
    noise, curve = result.fit.noise, result.fit.noise.curve
    low, high = curve.interval()
    m = np.geomspace(1.0, float(curve.clusters[-1]), 100)
    with figure(
        "Allan variance of the residuals with the fitted white and coloured noise", width_in=8.6, height_in=3.8
    ) as drawing:
        axes = drawing.axes
        sides = [curve.variance_db2 - low, high - curve.variance_db2]
        tau_s = m * curve.period_s
        still = GaussMarkov(1e-12, noise.coloured_tc_s)
        axes.errorbar(
            curve.tau_s, curve.variance_db2, sides, fmt="o", color=COLOURS[0], markersize=4.5, capsize=2.5,
            label="residuals, 95 % interval",
        )  # fmt: skip
        both = allan_model(m, noise.white_variance_db2, noise.noise, curve.period_s)
        white = allan_model(m, noise.white_variance_db2, still, curve.period_s)
        coloured = allan_model(m, 0.0, noise.noise, curve.period_s)
        axes.plot(tau_s, both, color=COLOURS[1], linewidth=1.8, label="white + coloured, fitted")
        axes.plot(tau_s, white, color=MUTED, linestyle="--", label="white")
        axes.plot(tau_s, coloured, color=COLOURS[2], linestyle="--", label="coloured")
        axes.set(xscale="log", yscale="log", xlabel="cluster length τ, s", ylabel="Allan variance, dB²")
        axes.set_ylim(0.5 * float(low.min()), 2.0 * float(min(high.max(), 4.0 * curve.variance_db2.max())))
        _plain_logarithm(axes.xaxis, curve.tau_s)
        _plain_logarithm(axes.yaxis, np.array(axes.get_ylim()))
        handles, labels = axes.get_legend_handles_labels()
        axes.legend(handles[-1:] + handles[:-1], labels[-1:] + labels[:-1], **_BESIDE)
    return drawing.html


def residual(result: Calibration) -> Markup:
    """The residual of the longest record over time, and the distribution of all residuals beside the normal one."""
    record, values = max(
        (pair for link in result.fit.links.values() for pair in zip(link.records, link.residuals_db, strict=True)),
        key=lambda pair: len(pair[1]),
    )
    everything = np.concatenate([link.path_loss.residual_db for link in result.fit.links.values()])
    std = float(everything.std())
    with figure(
        "Residual over time, and distribution of all residuals", 1, 2, height_in=2.8, width_in=_WIDTH_IN,
        sharey=True, width_ratios=[3.2, 1.0],
    ) as drawing:  # fmt: skip
        left, right = drawing.axes
        shown = thinned(len(values), _LINE)
        left.plot(record.time_s[shown] - record.time_s[0], values[shown], color=COLOURS[0], linewidth=0.9)
        left.set(xlabel="time, s", ylabel="RSS minus fit, dB")
        left.set_title(f"longest record: {shortened(record.link)}, {shortened(record.source, 40)}", loc="left")
        limit = float(np.quantile(np.abs(everything), 0.999)) * 1.1
        # Bins as wide as a whole number of steps of the RSS: others would be combed by rounding.
        step = result.fit.channel.quantisation_db or limit / 20.0
        bin_db = step * max(1, round(limit / 15.0 / step))
        edges = np.arange(-math.ceil(limit / bin_db), math.ceil(limit / bin_db) + 1) * bin_db
        share, _ = np.histogram(everything, edges, density=True)
        right.stairs(share, edges, orientation="horizontal", fill=True, color=COLOURS[0], alpha=0.45)
        level = np.linspace(-limit, limit, 100)
        normal = np.exp(-0.5 * (level / std) ** 2) / (std * math.sqrt(2.0 * math.pi))
        right.plot(normal, level, color=INK, linewidth=1.1, linestyle="--")
        right.set(xlabel="density, 1/dB", ylim=(-limit, limit))
        right.set_title(f"all; dashed: normal, {std:.1f} dB", loc="left")
    return drawing.html


def ranges(result: Calibration) -> Markup:
    """True and estimated range over time, on the best, the middle and the worst of the tested records."""
    found = result.scores["ekf-coloured"].ranges_m
    p80_m = [
        float(np.quantile(np.abs(range_m - record.distance_m), SHARES[1]))
        for range_m, record in zip(found, result.tested, strict=True)
    ]
    order = np.argsort(p80_m, kind="stable")
    chosen = {int(order[0]): "best", int(order[len(order) // 2]): "middle", int(order[-1]): "worst"}
    with figure(
        "True and estimated range over time", len(chosen), 1, width_in=_WIDTH_IN, height_in=0.5 + 2.1 * len(chosen),
        squeeze=False,
    ) as drawing:  # fmt: skip
        panels = drawing.axes.ravel()
        for axes, (k, rank) in zip(panels, sorted(chosen.items(), key=lambda item: p80_m[item[0]]), strict=True):
            _over_time(axes, result, result.tested[k], k)
            record = result.tested[k]
            which = f"{rank} record: " if len(chosen) > 1 else ""
            name = f"{shortened(record.link)}, {shortened(record.source, 40)}"
            axes.set_title(f"{which}{name}; coloured EKF: 80 % within {p80_m[k]:.2g} m", loc="left")
            axes.set_ylabel("range, m")
        panels[-1].set_xlabel("time, s")
        handles, labels = panels[0].get_legend_handles_labels()
        panels[0].figure.legend(handles, labels, loc="outside upper left", ncols=len(labels), markerscale=3.0)
    return drawing.html


def _over_time(axes: Any, result: Calibration, record: LogRecord, k: int) -> None:
    shown = thinned(len(record.time_s), _LINE)
    time_s = (record.time_s - record.time_s[0])[shown]
    names = [name for name in ("ekf-white", "ekf-coloured", "ekf-coloured-rate") if name in result.methods]
    inverted_m = result.scores["ls"].ranges_m[k][shown]
    axes.plot(time_s, inverted_m, ".", color=COLOURS[7], markersize=2.5, alpha=0.5, label="least squares, each sample")
    axes.plot(time_s, record.distance_m[shown], color=INK, linewidth=2.0, label="true")
    highest_m = float(record.distance_m.max())
    for name in names:
        style = "--" if result.methods[name].base is not None else "-"
        range_m = result.scores[name].ranges_m[k][shown]
        axes.plot(time_s, range_m, style, color=colour_of(name), label=result.methods[name].title)
        highest_m = max(highest_m, float(range_m.max()))
    axes.set_ylim(0.0, 1.15 * highest_m)
    axes.margins(x=0.01)


def shortened(name: str, length: int = 14) -> str:
    """A name that fits a panel's title; `$` would start mathematics."""
    name = name if len(name) <= length else f"{name[: length - 1]}…"
    return printable(name).replace("$", r"\$")


def _plain_logarithm(axis: Any, values: Floats) -> None:
    """Ticks of a logarithmic axis as plain numbers, more of them on a short one."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    decades = math.log10(float(values.max()) / float(values.min()))
    steps = (1.0,) if decades > 2.5 else (1.0, 2.0, 5.0) if decades > 1.0 else (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
