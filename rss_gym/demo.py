"""What `rss-gym demo` flies: the paper's rule beside others and the shipped agents, and both on a radio's own channel.

The channel is calibrated from recorded logs where they are at hand, in the folder that `RSS_GYM_DATA` names or in
`../shared/data` beside a checkout; else it is the shipped preset of a real telemetry link.
"""

from __future__ import annotations

import os
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

from rss_gym.baselines import AGENTS, able
from rss_gym.calibration.logs import read
from rss_gym.eval import evaluate, records, report, text
from rss_gym.eval.evaluate import Result
from rss_gym.eval.report import charts, tables
from rss_gym.eval.studies.calibration.calibrate import calibrate
from rss_gym.eval.studies.calibration.output import comment
from rss_gym.eval.studies.calibration.text import part
from rss_gym.eval.suites import find
from rss_gym.files import check_new, save_or_keep
from rss_gym.pages.markup import renderer
from rss_gym.pages.page import Section
from rss_gym.params import CHANNELS, Channel, load_channel
from rss_gym.radio import save_channel

SUITE = "encounter-v0"
REFERENCE = "orthogonal:radius_m=60"  # the replays show each policy beside it
RULE = tuple(f"orthogonal:radius_m={radius}" for radius in (15, 20, 30, 40, 60, 80, 120))
OTHERS = ("orca", "cbf", "mpc", "orthogonal@oracle:radius_m=60", "constant:right_m=30", "blind")

LOGS, PRESET = "wifi_walk", "quadcopter"
render = renderer(__file__)
RADIO, CHANNEL = "radio", "channel.toml"
SECTION = "On the channel of a recorded radio"
WIDTH = 116  # of the lines that are printed


@dataclass(frozen=True)
class Radio:
    """A channel, where it is from in words, and the lines above its table in the file."""

    channel: Channel
    origin: str
    comment: str


def radio() -> Radio:
    """The channel calibrated from the logs that are at hand, or else the preset."""
    folder = Path(os.environ.get("RSS_GYM_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data") / LOGS
    logs = sorted(folder.glob("*.csv"))
    return _calibrated(logs) if len(logs) > 1 else _preset()


def _preset() -> Radio:
    line = CHANNELS[PRESET].summary
    origin = f"No radio logs are at hand (RSS_GYM_DATA), so it is the preset {PRESET}: {line}"
    return Radio(load_channel(PRESET), origin, line)


def _calibrated(logs: list[Path]) -> Radio:
    """Fitted to the first half of the logs, tested on the others."""
    half = len(logs) // 2
    found = calibrate(read(logs[:half]), read(logs[half:]))
    far_m = max(record.distance_m.max() for record in found.fit.records)
    channel, p80_m = found.fit.channel, {name: score.p80_m.value for name, score in found.scores.items()}
    lines = [
        f"Calibrated from {part(found.fit.records, True, '')} of {LOGS}, at up to {far_m:.0f} m: path loss factor "
        f"{channel.path_loss_factor:.2f}, white {channel.white_variance_db2:.2g} dB^2, coloured "
        f"{channel.coloured_variance_db2:.2g} dB^2 over {channel.coloured_tc_s:.2g} s.",
        f"On the logs held out 80 % of the range errors are within {p80_m['ekf-coloured']:.1f} m "
        f"({p80_m['constant']:.1f} m for a constant guess).",
        *(f"Warning: {warning}." for warning in found.fit.warnings),
    ]
    return Radio(channel, " ".join(lines), comment(found))


def run(out: str | os.PathLike[str], episodes: int, workers: int) -> Path:
    """Fly everything, print the tables and write the record, its page, and below it the record on the other channel.

    Parameters
    ----------
    out : path
        New folder.
    episodes : int
        Encounters of each policy on each channel.
    workers : int
        Processes.

    Returns
    -------
    Path
        The path of the page.

    Raises
    ------
    ParamsError
        As `rss_gym.eval.evaluate`, or if the folder cannot be made.
    """
    check_new(out)
    found = radio()
    agents = [name for name in able(find(SUITE).params) if name in AGENTS]
    if not agents:
        print("No learned agent for this world comes with this version; the rules fly alone.")
    flown = ("none", *agents, *RULE, *OTHERS)
    _say(f"1/2 Flying {len(flown)} policies over the same {episodes:,} encounters on {workers} processes.")
    first = evaluate(flown, SUITE, episodes, workers=workers, reference=REFERENCE)
    print(text.table(first, colour=text.coloured(sys.stdout)))
    both = ("none", *agents, *RULE)
    _say(f"\n2/2 {len(both)} of them once more, on the channel of a radio. {found.origin}")
    second = evaluate(both, SUITE, episodes, workers=workers, reference=REFERENCE, channel=found.channel.to_dict())
    print(text.table(second, colour=text.coloured(sys.stdout)))

    def write(result: Result, folder: Path) -> None:
        records.save(second, folder / RADIO, page=report.write)
        save_channel(found.channel, folder / RADIO / CHANNEL, found.comment)
        report.write(result, folder, [section(second, found)])

    folder = save_or_keep(lambda place: records.save(first, place, page=write), out)
    return folder / report.REPORT


def section(result: Result, found: Radio) -> Section:
    """The flights on the radio's channel, for the page of the others."""
    parts = {"chart": charts.safety(result, caption=False), "scores": tables.main(result)}
    return Section(SECTION, render("radio.html", origin=found.origin, page=f"{RADIO}/{report.REPORT}", **parts))


def _say(line: str) -> None:
    print(textwrap.fill(line, WIDTH, replace_whitespace=False), flush=True)
