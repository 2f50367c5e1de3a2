"""`rss-gym calibrate`: a channel from radio logs."""

from __future__ import annotations

import argparse
import json
import os

HELP = "a channel from radio logs, with range errors on a test"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("fit", nargs="+", metavar="FIT", help="logs to fit")
    parser.add_argument(
        "--test",
        nargs="+",
        action="extend",
        default=[],
        metavar="TEST",
        help="logs to test on (default: the last third of each record)",
    )
    parser.add_argument("--format", default="csv", help="csv (default) or mavlink")
    parser.add_argument("--columns", default="", metavar="t=..,rss=..,dist=..", help="names of a table's columns")
    parser.add_argument("--out", required=True, metavar="FILE", help="channel to write, such as channel.toml")
    parser.add_argument("--report", metavar="DIR", help="new folder for the page and calibration.json")
    parser.add_argument("--json", action="store_true", help="print everything as JSON instead of the table")


def run(options: argparse.Namespace) -> None:
    """Fit, test, write the channel and print the table."""
    from rss_gym.calibration.logs import read
    from rss_gym.eval.studies.calibration import output
    from rss_gym.eval.studies.calibration.calibrate import calibrate
    from rss_gym.params import ParamsError

    output.check_outputs(options.out, options.report)
    columns = _columns(options.columns)
    fitted = {os.path.realpath(name) for name in options.fit}
    twice = next((name for name in options.test if os.path.realpath(name) in fitted), None)
    if twice is not None:
        raise ParamsError(f"log {twice!r} is to be fitted and tested; a test needs a log of its own")
    fit = read(options.fit, options.format, columns)
    test = read(options.test, options.format, columns) if options.test else None
    result = calibrate(fit, test or (), (*fit.notes, *(test.notes if test else ())))
    output.save(result, options.out, options.report)
    if options.json:
        print(json.dumps(output.to_dict(result), indent=1, allow_nan=False))
        return
    print(output.table(result))
    print(f"channel: {options.out}")
    if options.report is not None:
        print(f"report: {os.path.join(options.report, output.PAGE)}")


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
