"""A calibration from beginning to end: fit, tune, compare."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from rss_gym.calibration.fit import Fit, fit
from rss_gym.calibration.links import separate
from rss_gym.calibration.logs import LogRecord
from rss_gym.eval.studies.calibration.compare import EstimatorScore, compare
from rss_gym.eval.studies.calibration.methods import Method, available
from rss_gym.eval.studies.calibration.tune import at_the_edge, tune
from rss_gym.params import ParamsError
from rss_gym.ranging.track import Tuning

FITTED_SHARE = 2.0 / 3.0


@dataclass(frozen=True, eq=False)
class Calibration:
    """What was fitted, and how well it ranges.

    Parameters
    ----------
    fit : Fit
        Links, noise and the channel.
    tested : tuple of LogRecord
        The records that were held out.
    own_logs : bool
        Whether they come from logs of their own; else they are the last third of every record.
    methods, tunings, scores : dict
        By name of the method.
    notes : tuple of str
        What was left out.
    """

    fit: Fit
    tested: tuple[LogRecord, ...]
    own_logs: bool
    methods: dict[str, Method]
    tunings: dict[str, Tuning]
    scores: dict[str, EstimatorScore]
    notes: tuple[str, ...]

    @property
    def dropped(self) -> list[tuple[str, str, int, dict[str, int]]]:
        """Every link of every log: source, link, rows used, rows dropped by their reason."""
        table: dict[tuple[str, str], tuple[int, dict[str, int]]] = {}
        for record in (*self.fit.records, *self.tested):
            used, _ = table.get((record.source, record.link), (0, {}))
            table[record.source, record.link] = used + len(record.time_s), dict(record.reasons)
        return [(source, link, used, reasons) for (source, link), (used, reasons) in table.items()]


def calibrate(fitted: Sequence[LogRecord], tested: Sequence[LogRecord] = (), notes: Sequence[str] = ()) -> Calibration:
    """Fit a channel, tune the estimators on the same records, and compare them on others.

    Parameters
    ----------
    fitted : sequence of LogRecord
        As `rss_gym.calibration.logs.read` returns them.
    tested : sequence of LogRecord
        Records for the comparison. Without any, the last third of every record's samples is held out of the fit.
    notes : sequence of str
        Sentences of the reader, put before those of the calibration.

    Raises
    ------
    ParamsError
        If no link can be fitted, or none that was fitted can be tested.
    """
    own_logs = len(tested) > 0
    if not own_logs:
        cuts = [round(FITTED_SHARE * len(record.time_s)) for record in fitted]
        tested = [_part(record, slice(cut, None)) for record, cut in zip(fitted, cuts, strict=True)]
        fitted = [_part(record, slice(None, cut)) for record, cut in zip(fitted, cuts, strict=True)]
    fitted, tested, renamed = separate(fitted, tested)
    found = fit(fitted)
    kept = tuple(record for record in tested if record.link not in found.excluded)
    if not kept:
        raise ParamsError("the test has no link that can be used: all of its links were excluded from the fit")
    methods = available([*found.records, *kept])
    tunings = tune(found, methods)
    scores = compare(found, kept, methods, tunings)
    remarks = [*_notes(found, tested), *at_the_edge(methods, tunings)]
    return Calibration(found, kept, own_logs, methods, tunings, scores, (*notes, *renamed, *remarks))


def _part(record: LogRecord, part: slice) -> LogRecord:
    names = ("time_s", "rss_dbm", "distance_m", "range_rate_mps")
    arrays = {name: getattr(record, name) for name in names}
    return dataclasses.replace(record, **{k: values[part] for k, values in arrays.items() if values is not None})


def _notes(found: Fit, tested: Sequence[LogRecord]) -> list[str]:
    notes = []
    for link, reason in found.excluded.items():
        rows = sum(len(record.time_s) for record in tested if record.link == link)
        notes.append(f"link {link!r} is left out, with {rows:,} samples of the test: {reason}")
    known = {*found.links, *found.excluded}
    new = [link for link in dict.fromkeys(record.link for record in tested) if link not in known]
    notes += [f"link {link!r} was not fitted: it is tested with the path loss of the channel" for link in new]
    rated = sum(record.range_rate_mps is not None for record in [*found.records, *tested])
    if 0 < rated < len(found.records) + len(tested):
        notes.append("range rates are not used: not every record has velocities")
    return notes
