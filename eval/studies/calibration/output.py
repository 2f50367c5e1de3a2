"""What a calibration leaves behind: the channel as TOML, the report's folder, a dict for JSON, a table to print."""

from __future__ import annotations

import dataclasses
import json
import os
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import rss_gym
from rss_gym.calibration.fit import Fit
from rss_gym.calibration.logs import LogRecord
from rss_gym.eval.studies.calibration import report as page
from rss_gym.eval.studies.calibration.calibrate import Calibration
from rss_gym.eval.studies.calibration.compare import FIGURES
from rss_gym.eval.studies.calibration.text import errors, part
from rss_gym.files import check_new, new_folder
from rss_gym.pages.table import Table
from rss_gym.params import ParamsError, load_channel
from rss_gym.radio import save_channel

JSON, PAGE = "calibration.json", "index.html"
_WIDTH = 116


def check_outputs(out: str | os.PathLike[str], report: str | os.PathLike[str] | None = None) -> None:
    """Check that both can be written; called before a long run. A channel is replaced, another file never.

    Raises
    ------
    ParamsError
        If `out` does not end in `.toml`, lies in no folder or in that of `report`, or is there and is not a channel;
        for `report` as `rss_gym.files.check_new`.
    """
    name = os.fspath(out)
    if Path(name).suffix != ".toml" or "\0" in name:
        raise ParamsError(f"channel file {name!r} must have a name that ends in .toml")
    folder = Path(name).absolute().parent
    if not os.access(folder, os.W_OK) or not os.path.isdir(folder):
        raise ParamsError(f"channel file {name!r} cannot be written: {str(folder)!r} is not a folder to write to")
    if report is not None and Path(name).resolve().is_relative_to(check_new(report).resolve()):
        raise ParamsError(f"channel file {name!r} must lie outside the report's folder {os.fspath(report)!r}")
    if os.path.lexists(name):
        try:
            load_channel(Path(name).absolute())
        except ParamsError as error:
            raise ParamsError(f"file {name!r} exists and is not a channel; name a new one") from error


def save(result: Calibration, out: str | os.PathLike[str], report: str | os.PathLike[str] | None = None) -> None:
    """Write the channel, and the report's folder if one is named: both or neither.

    Raises
    ------
    ParamsError
        As `check_outputs`, or if the disk refuses.
    """
    check_outputs(out, report)
    if report is None:
        save_channel(result.fit.channel, out, comment(result))
        return
    with new_folder(report) as folder:
        (folder / PAGE).write_text(page.markup(result), encoding="utf-8")
        (folder / JSON).write_text(json.dumps(to_dict(result), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        save_channel(result.fit.channel, out, comment(result))


def comment(result: Calibration) -> str:
    """The lines above the channel's table: what it was fitted on, how sure it is, how well it ranged."""
    fit, noise = result.fit, result.fit.noise
    coloured, constant = result.scores["ekf-coloured"].p80_m.value, result.scores["constant"].p80_m.value
    lines = [
        f"Fitted by rss-gym calibrate to {part(fit.records, result.own_logs, 'first two thirds')}.",
        f"Path loss factor: {_factors(fit)}.",
        f"Standard errors of the noise: white {noise.white_variance_std_db2:.2g} dB^2, coloured "
        f"{noise.coloured_variance_std_db2:.2g} dB^2, time {noise.coloured_tc_std_s:.2g} s.",
        f"80 % of the range errors, coloured filter: within {coloured:.3g} m (constant guess {constant:.3g} m), on "
        f"{part(result.tested, result.own_logs, 'last third')}.",
        *(f"Warning: {warning}." for warning in fit.warnings),
    ]
    return "\n".join(piece for line in lines for piece in textwrap.wrap(line, _WIDTH))


def to_dict(result: Calibration) -> dict[str, Any]:
    """Everything that was found, as plain JSON types."""
    fit, noise, curve = result.fit, result.fit.noise, result.fit.noise.curve
    low, high = curve.interval()
    return {
        "version": rss_gym.__version__,
        "fitted": _summary(fit.records),
        "tested": _summary(result.tested) | {"held_out": "logs" if result.own_logs else "last third of each record"},
        "channel": fit.channel.to_dict(),
        "links": {name: _link(fit, name) for name in fit.links},
        "noise": {
            item.name: getattr(noise, item.name)
            for item in dataclasses.fields(noise)
            if item.name not in ("curve", "warnings")
        },
        "allan": {
            "tau_s": curve.tau_s.tolist(),
            "variance_db2": curve.variance_db2.tolist(),
            "low_db2": low.tolist(),
            "high_db2": high.tolist(),
            "model_db2": noise.model_db2.tolist(),
        },
        "methods": {name: _method(result, name) for name in result.methods},
        "excluded": fit.excluded,
        "dropped": [
            {"log": source, "link": link, "used": used, "dropped": reasons}
            for source, link, used, reasons in result.dropped
        ],
        "warnings": list(fit.warnings),
        "notes": list(result.notes),
    }


def _summary(records: Sequence[LogRecord]) -> dict[str, Any]:
    return {
        "logs": list(dict.fromkeys(record.source for record in records)),
        "links": len({record.link for record in records}),
        "records": len(records),
        "samples": sum(len(record.time_s) for record in records),
    }


def _link(fit: Fit, name: str) -> dict[str, Any]:
    link, (median_m, std_m) = fit.links[name], fit.range_prior_of(name)
    path_loss = {k: v for k, v in vars(link.path_loss).items() if k != "residual_db"}
    return {"samples": link.rows, "distance_median_m": median_m, "distance_std_m": std_m, **path_loss}


def _method(result: Calibration, name: str) -> dict[str, Any]:
    method, score = result.methods[name], result.scores[name]
    tuned = {} if method.tuned is None else {method.tuned: getattr(result.tunings[name], method.tuned)}
    return {"title": method.title, **tuned} | {key: dataclasses.asdict(getattr(score, key)) for key in FIGURES}


def table(result: Calibration) -> str:
    """What the command prints."""
    fit, channel, noise = result.fit, result.fit.channel, result.fit.noise
    found = {
        "path loss factor": _factors(fit),
        "offset": f"{channel.offset_dbm:.1f} dBm",
        "white noise": f"{noise.white_variance_db2:.3g} ± {noise.white_variance_std_db2:.2g} dB²",
        "coloured noise": f"{noise.coloured_variance_db2:.3g} ± {noise.coloured_variance_std_db2:.2g} dB²",
        "correlation time": f"{noise.coloured_tc_s:.3g} ± {noise.coloured_tc_std_s:.2g} s",
        "quantisation": f"{channel.quantisation_db:g} dB",
    }
    return "\n".join(
        [
            *textwrap.wrap(f"fitted: {part(fit.records, result.own_logs, 'first two thirds')}", _WIDTH),
            *textwrap.wrap(f"tested: {part(result.tested, result.own_logs, 'last third')}", _WIDTH),
            "found, with standard errors:",
            *(f"  {line}" for line in Table(["", ""], found.items()).lines(header=False)),
            "",
            *errors(result.methods, result.scores).lines(rule=True),
            *(f"note: {note}" for note in result.notes),
            *(f"warning: {warning}" for warning in fit.warnings),
        ]
    )


def _factors(fit: Fit) -> str:
    """The channel's path loss factor, with its standard error or the spread of the links."""
    value, fits = fit.channel.path_loss_factor, [link.path_loss for link in fit.links.values()]
    if len(fits) == 1:
        return f"{value:.2f} ± {fits[0].path_loss_factor_std:.2g}"
    factors = [one.path_loss_factor for one in fits]
    return f"{value:.2f}, the median of {len(fits)} links, {min(factors):.2f} to {max(factors):.2f}"
