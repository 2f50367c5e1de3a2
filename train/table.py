"""Tables of a training as CSV, whole at every moment, and cut back to the checkpoint when it goes on."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

from rss_gym.files import write_text


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
            with open(path, encoding="utf-8", newline="") as file:
                self.rows = [row for row in csv.DictReader(file) if int(row[steps]) <= until]
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
