"""The estimators on recorded radio logs: the table of docs/calibration.md (a minute)."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

from rss_gym.calibration.logs import LogRecord, read
from rss_gym.eval.studies.calibration import raw
from rss_gym.eval.studies.calibration.calibrate import Calibration, calibrate
from rss_gym.eval.studies.calibration.text import errors
from rss_gym.eval.studies.study import Part
from rss_gym.params import ParamsError

# Folder below DATA: what it is, the logs to fit, the logs to test.
SETS = {
    "ble_tracks": (
        "Bluetooth Low Energy beacon among twelve sensors indoors",
        ["straight_*.csv"],
        ["rectangular_*.csv", "zigzagging_*.csv"],
    ),
    "wifi_walk": (
        "802.11, a telephone carried past six access points",
        ["Library_213.csv", "Library_413.csv"],
        ["Library_513.csv", "Library_613.csv"],
    ),
}


def logs(folder: Path, patterns: list[str]) -> list[Path]:
    """The files of a folder that match, in the order of their names."""
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


def calibrated(folder: Path, name: str) -> Calibration:
    """One set, fitted and tested on its own logs."""
    _, fitted, tested = SETS[name]
    return calibrate(read(logs(folder / name, fitted)), read(logs(folder / name, tested)))


def samples(records: Sequence[LogRecord]) -> str:
    """`7,687 samples of 5 logs`."""
    return f"{sum(len(r.time_s) for r in records):,} samples of {len({r.source for r in records})} logs"


def table(result: Calibration, name: str) -> str:
    """One set as Markdown."""
    fit, scores = result.fit, result.scores
    noise, factors = fit.noise, [link.path_loss.path_loss_factor for link in fit.links.values()]
    p80_m = {key: score.p80_m.value for key, score in scores.items()}
    lines = [
        f"### {name}",
        "",
        f"{SETS[name][0]}. Fitted: {samples(fit.records)}; tested: {samples(result.tested)}; {len(fit.links)} links.",
        f"Path loss factor {min(factors):.2f} to {max(factors):.2f}, middle {fit.channel.path_loss_factor:.2f}; white "
        f"{noise.white_variance_db2:.3g} ± {noise.white_variance_std_db2:.1g} dB², coloured "
        f"{noise.coloured_variance_db2:.3g} ± {noise.coloured_variance_std_db2:.1g} dB² over "
        f"{noise.coloured_tc_s:.3g} ± {noise.coloured_tc_std_s:.1g} s.",
        *(f"Warning: {warning}." for warning in fit.warnings),
        f"At 80 % the coloured filter errs by {p80_m['ekf-coloured'] / p80_m['constant']:.2f} of the constant guess, "
        f"{p80_m['ekf-coloured'] / p80_m['ls']:.2f} of least squares and "
        f"{p80_m['ekf-coloured'] / p80_m['ekf-white']:.2f} of the white filter with R + S.",
        "",
        errors(result.methods, scores).markdown,
    ]
    return "\n".join(lines)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Where the logs are."""
    parser.add_argument("data", type=Path, metavar="DATA", help="folder with " + " and ".join(SETS))


def run(options: argparse.Namespace) -> Iterator[Part]:
    """One table a set."""
    for name in SETS:
        if not (options.data / name).is_dir():
            raise ParamsError(
                f"folder {str(options.data)!r} has no folder {name!r}; name the one that holds {', '.join(SETS)}"
            )
    yield Part(raw.table(), "docs/calibration.md", mark="raw")
    tables = "\n\n".join(table(calibrated(options.data, name), name) for name in SETS)
    yield Part(tables, "docs/calibration.md", mark="errors")
