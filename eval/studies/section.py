"""A section of a study: a table, and criteria with what was measured; as text and as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rss_gym.pages.table import Column, Table


@dataclass(frozen=True, slots=True)
class Scale:
    """How much a study flies.

    Attributes
    ----------
    episodes : int
        Encounters of a row, unless its section says otherwise.
    workers : int
        Processes.
    decisions : int
        Length of each training.
    seeds : int
        Trainings.
    """

    episodes: int = 20_000
    workers: int = 2
    decisions: int = 3_000_000
    seeds: int = 5


@dataclass(frozen=True, slots=True)
class Criterion:
    """What must hold, what was measured, and whether it holds."""

    text: str
    measured: str
    met: bool

    def __str__(self) -> str:
        """One line."""
        return f"{'met' if self.met else 'MISSED'}: {self.text}; measured: {self.measured}"


@dataclass(frozen=True, slots=True)
class Section:
    """One question of a study with its answer.

    Attributes
    ----------
    title : str
    how : str
        What was flown: encounters, split, seed.
    header : sequence of Column or str
    rows : sequence of sequences
        A value for each column, see `rss_gym.pages.table.Column.cell`.
    criteria : sequence of Criterion
    """

    title: str
    how: str
    header: Sequence[Column | str]
    rows: Sequence[Sequence[Any]]
    criteria: Sequence[Criterion] = ()

    @property
    def text(self) -> str:
        """For a terminal."""
        lines = Table(self.header, self.rows).lines()
        return "\n".join([self.title, self.how, "", *lines, "", *map(str, self.criteria), ""])

    @property
    def markdown(self) -> str:
        """For the docs."""
        criteria = [f"- {criterion}" for criterion in self.criteria]
        shown = Table(self.header, self.rows).markdown
        return "\n".join([f"## {self.title}", "", self.how, "", shown, "", *criteria, ""])
