"""The page of a calibration: what was fitted, and how the estimators range with it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

import rss_gym
from rss_gym.eval.studies.calibration import figures
from rss_gym.eval.studies.calibration.calibrate import Calibration
from rss_gym.eval.studies.calibration.compare import FIGURES, RECORDS_MIN, Figure
from rss_gym.eval.studies.calibration.text import part
from rss_gym.pages.figure import COLOURS
from rss_gym.pages.page import Section, render, text
from rss_gym.radio.identify import MISFIT

NORMAL = 1.96  # standard errors on each side of a 95 % interval


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
    return render("Calibration of a radio channel", _lead(result), sections)


def _lead(result: Calibration) -> str:
    channel = result.fit.channel
    p80_m = {name: result.scores[name].p80_m.value for name in ("ekf-coloured", "ls", "constant")}
    tags = {
        "path loss factor": f"{channel.path_loss_factor:.2f}",
        "offset": f"{channel.offset_dbm:.1f} dBm".replace("-", "−"),
        "white": f"{channel.white_variance_db2:.3g} dB²",
        "coloured": f"{channel.coloured_variance_db2:.3g} dB² over {channel.coloured_tc_s:.3g} s",
        "quantisation": f"{channel.quantisation_db:g} dB",
    }
    return (
        f'<p class="lead">The coloured filter ranges within <strong>{p80_m["ekf-coloured"]:.3g} m</strong> for 80 % of '
        f"the samples held out, least squares on each sample within {p80_m['ls']:.3g} m, a constant guess within "
        f"{p80_m['constant']:.3g} m.</p>\n"
        f'<p class="tags">{"".join(f"<span>{text(name)} {text(value)}</span>" for name, value in tags.items())}</p>'
        + "".join(f'<p class="note">Warning: {text(warning)}.</p>' for warning in result.fit.warnings)
    )


def _errors(result: Calibration) -> str:
    held = "logs" if result.own_logs else "the last third of each record,"
    interval = (
        "Brackets: 95 % intervals from bootstrap samples of whole records (one link on one log)."
        if len(result.tested) >= RECORDS_MIN
        else f"No intervals: they need at least {RECORDS_MIN} records (one link on one log)."
    )
    rows = []
    for name, method in result.methods.items():
        noise = getattr(result.tunings[name], method.tuned) if method.tuned is not None else None
        unit = "1/s" if method.tuned is not None and method.tuned.startswith("relative") else "m²/s"
        tuned = "<td></td>" if noise is None else f'<td data-value="{noise!r}">{noise:.2g} {unit}</td>'
        score = result.scores[name]
        rows.append([_title(name, method.title), *(_cell(getattr(score, key)) for key in FIGURES), tuned])
    headings = ["method", *(f"{title}, m" for title in FIGURES.values()), "process noise"]
    return (
        f'<p class="text">Estimated minus true range, absolute, on {held} held out of the fit. Path loss and range '
        "prior are those fitted for each link; process noise was tuned on the fitted part for the least 80 % error, "
        "each filter by itself. The constant guess is the median distance of the link.</p>\n"
        + figures.errors(result)
        + _table(headings, rows)
        + f'<p class="note">{interval}</p>'
    )


def _ranges(result: Calibration) -> str:
    which = "The records on which the coloured filter errs least, middling and most. " if len(result.tested) > 1 else ""
    return f'<p class="text">{which}Single samples inverted may lie above the frame.</p>\n' + figures.ranges(result)


def _path_loss(result: Calibration) -> str:
    links = result.fit.links
    shown = f" The first {figures.LINKS_SHOWN} of {len(links)} links." if len(links) > figures.LINKS_SHOWN else ""
    rows = []
    for name, link in links.items():
        fit, distance_m = link.path_loss, link.distance_m
        cells = [
            f'<td data-value="{link.rows}">{link.rows:,}</td>',
            f'<td data-value="{distance_m.min()!r}">{distance_m.min():.3g} to {distance_m.max():.3g}</td>',
            _cell(_with_error(fit.path_loss_factor, fit.path_loss_factor_std)),
            _cell(_with_error(fit.offset_dbm, fit.offset_std_dbm), 1),
            f'<td data-value="{fit.residual_db.std()!r}">{fit.residual_db.std():.1f}</td>',
        ]
        rows.append([f'<th scope="row">{text(name)}</th>', *cells])
    headings = ["link", "samples", "distance, m", "path loss factor", "offset, dBm", "residual, dB"]
    middle = ", a link at a time. The channel has their median factor, and their median RSS at the middle distance"
    return (
        f'<p class="text">Path loss factor and offset fitted together{middle if len(links) > 1 else ""}.{shown}</p>\n'
        + figures.path_loss(result)
        + _table(headings, rows)
        + '<p class="note">Brackets: 95 % intervals that take the residual as the coloured noise below.</p>'
    )


def _noise(result: Calibration) -> str:
    noise = result.fit.noise
    rows = [
        ("white variance R, rounding included", noise.white_variance_db2, noise.white_variance_std_db2, "dB²"),
        ("coloured variance S", noise.coloured_variance_db2, noise.coloured_variance_std_db2, "dB²"),
        ("correlation time", noise.coloured_tc_s, noise.coloured_tc_std_s, "s"),
    ]
    facts = {name: f"{value:.3g} ± {NORMAL * std:.2g} {unit}" for name, value, std, unit in rows}
    facts["model"] = f"p = {noise.misfit:.2g} for white plus one Gauss-Markov noise; below {MISFIT:g} it is rejected"
    return (
        '<p class="text">White and Gauss-Markov noise fitted to the Allan variance of all residuals, with 95 % '
        "intervals of both.</p>\n"
        + figures.allan(result)
        + _facts(facts)
        + "<h3>Residual</h3>\n"
        + figures.residual(result)
    )


def _rows(result: Calibration) -> str:
    """What was used of each log, and what was not, by its reason."""
    reasons = list(dict.fromkeys(reason for *_, dropped in result.dropped for reason in dropped))
    rows = []
    for source, link, used, dropped in result.dropped:
        counts = [used, *(dropped.get(reason, 0) for reason in reasons)]
        cells = [f'<td data-value="{count}">{count:,}</td>' if count else "<td></td>" for count in counts]
        rows.append([f'<th scope="row">{text(source)}</th>', f"<td>{text(link)}</td>", *cells])
    said = "No row was dropped." if not reasons else "A row counts under the first reason that it has."
    return f'<p class="text">{said}</p>\n' + _table(["log", "link", "used", *reasons], rows)


def _run(result: Calibration) -> str:
    facts = {
        "fitted": part(result.fit.records, result.own_logs, "first two thirds"),
        "tested": part(result.tested, result.own_logs, "last third"),
        "rss-gym": rss_gym.__version__,
    }
    notes = "".join(f"<li>{text(note)}</li>" for note in result.notes)
    channel = json.dumps(result.fit.channel.to_dict(), indent=1)
    return (
        _facts(facts)
        + (f"<h3>Notes</h3>\n<ul>{notes}</ul>" if notes else "")
        + f"<details><summary>Channel</summary><pre>{text(channel)}</pre></details>"
    )


def _title(name: str, title: str) -> str:
    colour = figures.colour_of(name)
    class_ = f"c{COLOURS.index(colour)}" if colour in COLOURS else "nominal"
    return f'<th scope="row"><span class="who"><span class="dot {class_}"></span><span>{text(title)}</span></span></th>'


def _with_error(value: float, std: float) -> Figure:
    return Figure(value, value - NORMAL * std, value + NORMAL * std)


def _cell(figure: Figure, digits: int = 2) -> str:
    value = f"{figure.value:.{digits}f}"
    if figure.low is not None:
        value += f' <span class="interval">[{figure.low:.{digits}f}, {figure.high:.{digits}f}]</span>'
    value = value.replace("-", "−")
    return f'<td data-value="{figure.value!r}">{value}</td>'


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f'<th scope="col">{text(heading)}</th>' for heading in headings)
    body = "".join(f"<tr>{''.join(cells)}</tr>\n" for cells in rows)
    table = f'<table class="sortable"><thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table>'
    return f'<div class="scroll" tabindex="0">{table}</div>\n'


def _facts(facts: dict[str, str]) -> str:
    return f"<dl>{''.join(f'<dt>{text(name)}</dt><dd>{text(value)}</dd>' for name, value in facts.items())}</dl>\n"
