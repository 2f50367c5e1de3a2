"""Draws the page of a saved record again, from its files alone."""

from __future__ import annotations

import os
from pathlib import Path

from rss_gym.eval import report
from rss_gym.eval.reading import load, read_flights, result_of
from rss_gym.files import write_text


def redraw(folder: str | os.PathLike[str]) -> Path:
    """Write `report.html` of a record again; without `flights.json` it has no replays and says so.

    Parameters
    ----------
    folder : path
        Of `rss-gym eval --out`, or of `rss_gym.eval.records.save`.

    Returns
    -------
    Path
        The path of the page, byte for byte the one that was written with the record by the same version of this
        package.

    Raises
    ------
    RecordError
        If the folder does not hold an intact record; the sentence names file, field, value and what would be right.
    ParamsError
        If the page cannot be written.
    """
    record = load(folder)
    page = report.markup(result_of(record), read_flights(record), record.versions)
    return write_text(record.folder / report.REPORT, page)
