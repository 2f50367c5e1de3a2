"""`rss-gym simulate-log`: the log of a simulated flight in the form that a real one would have."""

from __future__ import annotations

import argparse

HELP = "write the log of a simulated flight, to try rss-gym calibrate"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--format",
        default="csv",
        metavar="NAME",
        help="csv (default), positions, milliseconds, wide, prose, bare, relative, edgetx, mavlink, dataflash, ulog, "
        "rosbag or mcap",
    )
    parser.add_argument(
        "--channel", default="outdoor", metavar="PRESET|FILE", help="channel of the radio (default: outdoor)"
    )
    parser.add_argument("--seconds", type=float, default=300.0, help="time in the air (default: 300)")
    parser.add_argument("--rate", type=float, default=5.0, metavar="HZ", help="samples of the RSS (default: 5)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the path and the noise (default: 0)")
    parser.add_argument("--out", required=True, metavar="FILE", help="new file for the log")


def run(options: argparse.Namespace) -> None:
    """Fly, and write the log."""
    from rss_gym.calibration.simulated import fly, write

    flight = fly(options.channel, seconds=options.seconds, rate_hz=options.rate, seed=options.seed)
    print(f"log: {write(flight, options.format, options.out)}")
