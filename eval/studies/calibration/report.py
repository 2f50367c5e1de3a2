"""The page of a calibration: what was fitted, and how the estimators range with it."""

from __future__ import annotations

import json

from markupsafe import Markup

import rss_gym
from rss_gym.eval.studies.calibration import figures
from rss_gym.eval.studies.calibration.calibrate import Calibration
from rss_gym.eval.studies.calibration.compare import FIGURES, RECORDS_MIN, Figure
from rss_gym.eval.studies.calibration.text import part
from rss_gym.pages import page
from rss_gym.pages.figure import COLOURS
from rss_gym.pages.markup import minus, renderer
from rss_gym.pages.page import Section
from rss_gym.pages.table import Cell, Column, Table
from rss_gym.radio.identify import MISFIT

NORMAL = 1.96  # standard errors on each side of a 95 % interval
LINKS = (
    "link",
    Column("samples", form=","),
    Column("distance", "m"),
    Column("path loss factor", form=".2f"),
    Column("offset", "dBm", ".1f"),
    Column("residual", "dB", ".1f"),
)
render = renderer(__file__)


def markup(result: Calibration) -> str:
    """The page as text; the same result gives the same text."""
    sections = [
        Section("Range errors", _errors(result)),
        Section("Ranges over time", _ranges(result)),
        Section("Path loss", _path_loss(result)),
        Section("Noise", _noise(result)),
        Section("Rows", _rows(result)),
        Section("Run", _run(result)),
    ]
    return page.render("Calibration of a radio channel", _lead(result), sections)


def _lead(result: Calibration) -> Markup:
    channel = result.fit.channel
    tags = {
        "path loss factor": f"{channel.path_loss_factor:.2f}",
        "offset": f"{minus(f'{channel.offset_dbm:.1f}')} dBm",
        "white": f"{channel.white_variance_db2:.3g} dB²",
        "coloured": f"{channel.coloured_variance_db2:.3g} dB² over {channel.coloured_tc_s:.3g} s",
        "quantisation": f"{channel.quantisation_db:g} dB",
    }
    p80_m = {name: f"{result.scores[name].p80_m.value:.3g}" for name in ("ekf-coloured", "ls", "constant")}
    return render("lead.html", p80_m=p80_m, tags=tags, warnings=result.fit.warnings)


def _errors(result: Calibration) -> Markup:
    rows = []
    for name, method in result.methods.items():
        score = result.scores[name]
        rows.append([_title(name, method.title), *(getattr(score, key) for key in FIGURES), _tuned(result, name)])
    columns = ["method", *(Column(title, "m", ".2f") for title in FIGURES.values()), "process noise"]
    return render(
        "errors.html", figure=figures.errors(result), table=Table(columns, rows, "sortable"),
        own_logs=result.own_logs, intervals=len(result.tested) >= RECORDS_MIN, least=RECORDS_MIN,
    )  # fmt: skip


def _tuned(result: Calibration, name: str) -> Cell:
    tuned = result.methods[name].tuned
    if tuned is None:
        return Cell("")
    noise = getattr(result.tunings[name], tuned)
    return Cell(f"{noise:.2g} {'1/s' if tuned.startswith('relative') else 'm²/s'}", noise)


def _ranges(result: Calibration) -> Markup:
    return render("ranges.html", figure=figures.ranges(result), several=len(result.tested) > 1)


def _path_loss(result: Calibration) -> Markup:
    links, rows = result.fit.links, []
    for name, link in links.items():
        fit, distance_m = link.path_loss, link.distance_m
        span = Cell(f"{distance_m.min():.3g} to {distance_m.max():.3g}", distance_m.min())
        factor = _with_error(fit.path_loss_factor, fit.path_loss_factor_std)
        offset = _with_error(fit.offset_dbm, fit.offset_std_dbm)
        rows.append([name, link.rows, span, factor, offset, float(fit.residual_db.std())])
    return render(
        "path_loss.html", figure=figures.path_loss(result), table=Table(LINKS, rows, "sortable"), links=len(links),
        most=figures.LINKS_SHOWN,
    )  # fmt: skip


def _noise(result: Calibration) -> Markup:
    noise = result.fit.noise
    rows = [
        ("white variance R, rounding included", noise.white_variance_db2, noise.white_variance_std_db2, "dB²"),
        ("coloured variance S", noise.coloured_variance_db2, noise.coloured_variance_std_db2, "dB²"),
        ("correlation time", noise.coloured_tc_s, noise.coloured_tc_std_s, "s"),
    ]
    facts = {name: f"{value:.3g} ± {NORMAL * std:.2g} {unit}" for name, value, std, unit in rows}
    facts["model"] = f"p = {noise.misfit:.2g} for white plus one Gauss-Markov noise; below {MISFIT:g} it is rejected"
    return render("noise.html", allan=figures.allan(result), facts=facts, residual=figures.residual(result))


def _rows(result: Calibration) -> Markup:
    """What was used of each log, and what was not, by its reason."""
    reasons = list(dict.fromkeys(reason for *_, dropped in result.dropped for reason in dropped))
    rows = [
        [source, link, *((count or Cell("")) for count in (used, *(dropped.get(reason, 0) for reason in reasons)))]
        for source, link, used, dropped in result.dropped
    ]
    columns = ["log", "link", *(Column(title, form=",") for title in ("used", *reasons))]
    return render("rows.html", reasons=reasons, table=Table(columns, rows, "sortable"))


def _run(result: Calibration) -> Markup:
    facts = {
        "fitted": part(result.fit.records, result.own_logs, "first two thirds"),
        "tested": part(result.tested, result.own_logs, "last third"),
        "rss-gym": rss_gym.__version__,
    }
    channel = json.dumps(result.fit.channel.to_dict(), indent=1)
    return render("run.html", facts=facts, notes=result.notes, channel=channel)


def _title(name: str, title: str) -> Cell:
    colour = figures.colour_of(name)
    return Cell(title, dot=f"c{COLOURS.index(colour)}" if colour in COLOURS else "nominal")


def _with_error(value: float, std: float) -> Figure:
    return Figure(value, value - NORMAL * std, value + NORMAL * std)
