"""Which records are of one link: a radio that was mounted or set anew has another offset under its old name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats

_EPOCH_S = 1e8  # clocks beyond count from 1970, so that logs can be told earlier and later


def separate(
    fitted: Sequence[LogRecord], tested: Sequence[LogRecord]
) -> tuple[list[LogRecord], list[LogRecord], list[str]]:
    """Give records of one link whose offsets differ by more than the noise names of their own.

    The offsets of a link's files are estimated with one common path loss factor. Sorted, they are cut wherever two
    neighbours differ by more than the standard deviation of the residuals. A tested log that was not fitted belongs to
    the fitted log that is nearest in time, or, where the logs have no absolute clock, to the one with the nearest
    offset.

    Returns
    -------
    fitted, tested : lists of LogRecord
        The same records, some renamed.
    notes : list of str
        What was renamed, and why.
    """
    names: dict[tuple[str, str], str] = {}
    notes: list[str] = []
    for link in dict.fromkeys(record.link for record in fitted):
        own = [record for record in fitted if record.link == link]
        if len(own) < 2:
            continue
        slope, levels, noise_db = _levels(own)
        groups = _groups(levels, noise_db)
        if len(groups) == 1:
            continue
        spread_db = float(levels.max() - levels.min())
        for group in groups:
            sources = list(dict.fromkeys(own[k].source for k in sorted(group)))
            more = f" and {len(sources) - 1} more" if len(sources) > 1 else ""
            names |= {(link, source): f"{link} ({sources[0]}{more})" for source in sources}
        notes.append(
            f"link {link!r} is taken as {len(groups)} links, "
            f"{', '.join(dict.fromkeys(names[link, r.source] for r in own))}: "
            f"the offsets of its logs differ by up to {spread_db:.1f} dB, the noise has {noise_db:.1f} dB"
        )
        for record in tested:
            if record.link == link and (link, record.source) not in names:
                by_time = all(one.start_s > _EPOCH_S for one in (record, *own))
                level = _level(record, slope)
                distance = [
                    abs(r.start_s - record.start_s) if by_time else abs(x - level)
                    for r, x in zip(own, levels, strict=True)
                ]
                names[link, record.source] = names[link, own[int(np.argmin(distance))].source]
                how = "nearest in time" if by_time else "whose offset is nearest to its own"
                notes.append(f"log {record.source!r} is tested as {names[link, record.source]!r}, the link {how}")
    return _renamed(fitted, names), _renamed(tested, names), notes


def _renamed(records: Sequence[LogRecord], names: dict[tuple[str, str], str]) -> list[LogRecord]:
    return [dataclasses.replace(r, link=names.get((r.link, r.source), r.link)) for r in records]


def _levels(records: Sequence[LogRecord]) -> tuple[float, Floats, float]:
    """Common slope in dB a decade, each record's RSS at 1 m with it, and the standard deviation about these lines."""
    x = [np.log10(record.distance_m) for record in records]
    y = [record.rss_dbm for record in records]
    sxx = sum(float(((one - one.mean()) ** 2).sum()) for one in x)
    sxy = sum(float(((a - a.mean()) * (b - b.mean())).sum()) for a, b in zip(x, y, strict=True))
    slope = sxy / sxx if sxx > 0.0 else 0.0
    levels = np.array([_level(record, slope) for record in records])
    residuals = np.concatenate([b - slope * a - level for a, b, level in zip(x, y, levels, strict=True)])
    return slope, levels, float(residuals.std())


def _level(record: LogRecord, slope: float) -> float:
    return float(record.rss_dbm.mean() - slope * np.log10(record.distance_m).mean())


def _groups(levels: Floats, noise_db: float) -> list[list[int]]:
    """Indices of levels with no gap above the noise between them."""
    order = np.argsort(levels, kind="stable")
    cuts = np.flatnonzero(np.diff(levels[order]) > max(noise_db, 1e-6)) + 1
    return [part.tolist() for part in np.split(order, cuts)]
