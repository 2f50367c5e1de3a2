"""Words that the printed table, the channel file and the page share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rss_gym.calibration.logs import LogRecord
from rss_gym.eval.studies.calibration.compare import FIGURES, EstimatorScore
from rss_gym.eval.studies.calibration.methods import Method
from rss_gym.pages.table import Column, Table

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


def errors(methods: Mapping[str, Method], scores: Mapping[str, EstimatorScore]) -> Table:
    """The range errors of every method."""
    rows = ([method.title, *(getattr(scores[name], key) for key in FIGURES)] for name, method in methods.items())
    return Table(["range error, m", *(Column(title, form=".2f") for title in FIGURES.values())], rows)
