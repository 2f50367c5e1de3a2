"""`rss-gym calibrate`: a channel from radio logs."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
from typing import Any

from rss_gym.commands.shared import add_out

HELP = "fit a channel to radio logs, and compare the range errors of the estimators on other logs"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    # A station south of the equator begins with a minus.
    parser._negative_number_matcher = re.compile(r"^-\d[-\d.,e]*$")
    parser.add_argument("fit", nargs="*", metavar="FIT", help="radio logs that the channel is fitted to")
    parser.add_argument(
        "--test",
        nargs="+",
        action="extend",
        default=[],
        metavar="TEST",
        help="logs to test on (default: the last third of each record)",
    )
    parser.add_argument("--inspect", action="store_true", help="only say what the logs hold and what would be dropped")
    parser.add_argument("--out", metavar="FILE", help="file for the channel, such as channel.toml")
    add_out(parser, "DIR", "new folder for the page and calibration.json", required=False, name="report")
    parser.add_argument("--json", action="store_true", help="print everything as JSON instead of the table")
    reading = parser.add_argument_group("reading", "where a log does not say so itself")
    reading.add_argument(
        "--format", metavar="NAME", help="format of the logs: csv, mavlink, ... (default: found from the content)"
    )
    reading.add_argument(
        "--columns",
        default="",
        metavar="t=..,rss=..,dist=..",
        help="names of the columns of a table or the fields of a bag; 1=t,2=rss,3=dist for a table without a header",
    )
    reading.add_argument(
        "--time-unit", choices=("s", "ms", "us", "ns"), help="unit of the time (default: found from the numbers)"
    )
    reading.add_argument(
        "--melt",
        nargs="?",
        const="*",
        metavar="PATTERN",
        help="the table has columns for each link; PATTERN names them, such as rss=rss_*,dist=dist_*",
    )
    reading.add_argument(
        "--truth", metavar="FILE", help="table with the true distances or positions, over the same clock"
    )
    reading.add_argument("--offset-db", type=float, default=0.0, metavar="DB", help="level to add to a relative power")
    reading.add_argument(
        "--station",
        metavar="LAT,LON,ALT",
        help="position of the fixed end of the link: degrees and m, or x,y,z in m for local positions",
    )
    reading.add_argument(
        "--from",
        type=float,
        default=-math.inf,
        dest="from_s",
        metavar="S",
        help="use rows from S seconds after the first one on",
    )
    reading.add_argument(
        "--to",
        type=float,
        default=math.inf,
        dest="to_s",
        metavar="S",
        help="use rows until S seconds after the first one",
    )
    reading.add_argument(
        "--whole", action="store_true", help="also use rows on the ground and rows while the aircraft is not armed"
    )


def run(options: argparse.Namespace) -> None:
    """Inspect, or fit, test and write."""
    from rss_gym.calibration.logs import read
    from rss_gym.eval.studies.calibration import output
    from rss_gym.eval.studies.calibration.calibrate import calibrate
    from rss_gym.eval.studies.calibration.inspect import inspect
    from rss_gym.params import ParamsError

    if options.melt is not None and os.path.isfile(options.melt):  # `--melt LOG`: the pattern was left out
        options.fit, options.melt = [options.melt, *options.fit], "*"
    if not options.fit:
        raise ParamsError("FIT is missing: name the logs to fit")
    reading = _reading(options)
    if options.inspect:
        if options.out is not None:
            raise ParamsError("--inspect writes no channel: give it without --out")
        inspect([*options.fit, *options.test], options.format, reading, options.report)
        return
    if options.out is None:
        raise ParamsError("name the channel to write by --out, or give --inspect")
    output.check_outputs(options.out, options.report)
    fitted = {os.path.realpath(name) for name in options.fit}
    twice = next((name for name in options.test if os.path.realpath(name) in fitted), None)
    if twice is not None:
        raise ParamsError(f"log {twice!r} is to be fitted and tested; a test needs a log of its own")
    logs = read([*options.fit, *options.test], options.format, **reading)
    fit = [record for record in logs if record.file < len(options.fit)]
    test = [record for record in logs if record.file >= len(options.fit)]
    result = calibrate(fit, test, logs.notes)
    output.save(result, options.out, options.report)
    if options.json:
        print(json.dumps(output.to_dict(result), indent=1, allow_nan=False))
        return
    print(output.table(result))
    print(f"channel: {options.out}")
    if options.report is not None:
        print(f"report: {os.path.join(options.report, output.PAGE)}")


def _reading(options: argparse.Namespace) -> dict[str, Any]:
    """The keyword arguments of `read`."""
    return {
        "columns": _columns(options.columns),
        "time_unit": options.time_unit,
        "melt": options.melt,
        "truth": options.truth,
        "offset_db": options.offset_db,
        "station": _station(options.station),
        "from_s": options.from_s,
        "to_s": options.to_s,
        "whole": options.whole,
    }


def _columns(text: str) -> dict[str, str]:
    """`t=time,rss=power` as a dict."""
    from rss_gym.params import ParamsError

    columns: dict[str, str] = {}
    for item in filter(None, text.split(",")):
        key, equals, name = (part.strip() for part in item.partition("="))
        if not (key and equals and name) or key in columns:
            raise ParamsError(f"columns must be KEY=NAME pairs of different keys with commas between, got {item!r}")
        columns[key] = name
    return columns


def _station(text: str | None) -> tuple[float, float, float] | None:
    from rss_gym.params import ParamsError

    if text is None:
        return None
    try:
        first, second, third = (float(part) for part in text.split(","))
    except ValueError:
        raise ParamsError(
            f"station must be LAT,LON,ALT or X,Y,Z, three numbers with commas between, got {text!r}"
        ) from None
    return first, second, third
