"""Words that the printed table, the channel file and the page share."""

from __future__ import annotations

from collections.abc import Sequence

from rss_gym.calibration.logs import LogRecord
from rss_gym.eval.studies.calibration.compare import Figure

_NAMED = 12  # logs in a comment


def part(records: Sequence[LogRecord], whole: bool, share: str) -> str:
    """Samples, links and logs of one part: `7,694 samples of 12 links in straight_01.csv, straight_02.csv`."""
    names = [printable(name) for name in dict.fromkeys(record.source for record in records)]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    links = len({record.link for record in records})
    return (
        f"{sum(len(record.time_s) for record in records):,} samples of {links} link{'s' if links > 1 else ''} in "
        f"{'' if whole else f'the {share} of '}{', '.join(names[:_NAMED])}{more}"
    )


def printable(name: str) -> str:
    """A name from outside without line breaks and control characters."""
    return "".join(c if c.isprintable() else "?" for c in name)


def cell(figure: Figure) -> str:
    """Value, and interval if there is one."""
    ends = "" if figure.low is None or figure.high is None else f" [{figure.low:.2f}, {figure.high:.2f}]"
    return f"{figure.value:.2f}{ends}"
