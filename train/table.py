"""Tables of a training as CSV, whole at every moment, and cut back to the checkpoint when it goes on."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

from rss_gym.files import write_text
from rss_gym.params import ParamsError


class Table:
    """Rows that are added one at a time; the file is written anew with each, as a row may bring new columns.

    Parameters
    ----------
    path : Path
        The file; its rows are read if it exists.
    steps : str
        The column that counts them.
    until : int
        Rows of later steps are dropped: they were made after the checkpoint.
    """

    def __init__(self, path: Path, steps: str, until: int = 0) -> None:
        self.path, self.rows = path, []
        if path.exists():
            try:
                with open(path, encoding="utf-8", newline="") as file:
                    reader = csv.DictReader(file, strict=True)
                    if reader.fieldnames and steps not in reader.fieldnames:
                        raise KeyError(steps)
                    self.rows = [row for row in reader if int(row[steps]) <= until]
                if any(None in row or None in row.values() for row in self.rows):
                    raise ValueError("a row has another number of columns than the header")
            except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
                what = f"no column {steps!r}" if isinstance(error, KeyError) else str(error)
                raise ParamsError(
                    f"{str(path)!r} is no table of a training ({what}); put it aside, and the training goes on without"
                ) from error
            self._write()

    rows: list[dict[str, Any]]

    def add(self, row: dict[str, Any]) -> None:
        """Add a row."""
        self.rows.append(row)
        self._write()

    def _write(self) -> None:
        text = io.StringIO()
        columns = dict.fromkeys(name for row in self.rows for name in row)
        writer = csv.DictWriter(text, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows)
        write_text(self.path, text.getvalue())
