"""Tables: columns and rows once, shown as text for a terminal, as Markdown, and as markup of a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import MISSING

_render = renderer(__file__)


@dataclass(frozen=True)
class Cell:
    """What one cell shows.

    Parameters
    ----------
    text : str
        Shown everywhere; None where there is no value.
    value, low, high : float, optional
        All digits, by which a page sorts; None for a text.
    ends : (str, str), optional
        The ends of the interval, as shown.
    unit : str
        Behind the number, where the rows of a column have different ones.
    mark : str
        Why there is an asterisk behind the text; empty without one.
    small : str or Markup
        A second line, on a page only.
    dot : str, optional
        On a page only: the name of a policy, of limited width, behind a dot with this class of colour, if it is one.
    class_, style : str
        The class and the style of the element, on a page only.
    strong : bool
        In bold in Markdown and on a page.
    """

    text: str | Markup | None
    value: float | None = None
    low: float | None = None
    high: float | None = None
    ends: tuple[str, str] | None = None
    unit: str = ""
    mark: str = ""
    small: str | Markup = ""
    dot: str | None = None
    class_: str = ""
    style: str = ""
    strong: bool = False

    @property
    def plain(self) -> str:
        """In one line of text."""
        if self.text is None:
            return "-"
        ends = f" [{self.ends[0]}, {self.ends[1]}]" if self.ends else ""
        return f"{self.text}{'*' * bool(self.mark)}{ends}" + (f" {self.unit}" if self.unit else "")

    @property
    def markdown(self) -> str:
        """In a line of Markdown; an asterisk stands apart, where it begins no emphasis."""
        bold = "**" * self.strong
        shown = self.plain.replace("|", "\\|")
        return f"{bold}{shown[:-1] + ' *' if self.mark else shown}{bold}"


@dataclass(frozen=True)
class Column:
    """One column: what it is called, and how its values are shown.

    Parameters
    ----------
    title : str
    unit : str
        Behind the title; empty for pure numbers and words.
    form : str or callable
        Format of numbers, as of `format`, or a function from a number to text.
    factor : float
        What is shown is the value times this.
    interval : bool
        Whether the interval of an estimate is shown.
    words : bool
        On a page to the left, as words are, not to the right.
    meaning : str
        What the column holds, as a tool tip of a page.
    note : str
        Second line of the heading, on a page only.
    head : bool
        On a page the heading of each row is in this column; without any it is the first.
    """

    title: str
    unit: str = ""
    form: str | Callable[[float], str] = ""
    factor: float = 1.0
    interval: bool = True
    words: bool = False
    meaning: str = ""
    note: str = ""
    head: bool = False

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title}, {self.unit}" if self.unit else self.title

    def shown(self, value: float) -> str:
        """A number in the column's format."""
        scaled = value if self.factor == 1.0 else value * self.factor  # whole numbers stay whole
        return self.form(scaled) if callable(self.form) else format(scaled, self.form)

    def cell(self, value: Any) -> Cell:
        """The cell of a text, a number, a value with an interval (`value`, `low`, `high`), None, or of a cell."""
        if isinstance(value, Cell):
            return value
        if value is None or isinstance(value, str):
            return Cell(value)
        if isinstance(value, (int, float)):
            return Cell(self.shown(value), value)
        low, high = value.low, value.high
        if value.value is None:
            return Cell(None)
        bare = not self.interval or low is None or high is None
        ends = None if bare else (self.shown(low), self.shown(high))
        return Cell(self.shown(value.value), value.value, low, high, ends)


@dataclass(frozen=True)
class Row:
    """The cells of a row, or the values of which its columns make them, and its class on a page."""

    cells: Sequence[Any]
    class_: str = ""


class Table:
    """Rows under columns.

    Parameters
    ----------
    columns : iterable of Column or str
        A text is the title of a column without a unit.
    rows : iterable of Row or sequence
        A value for each column, see `Column.cell`.
    class_ : str
        The class of the table on a page; `sortable` lets a reader sort by a click.
    """

    def __init__(self, columns: Iterable[Any], rows: Iterable[Row | Sequence[Any]], class_: str = "") -> None:
        self.columns = [Column(column) if isinstance(column, str) else column for column in columns]
        self.class_ = class_
        self.rows = [
            Row([column.cell(value) for column, value in zip(self.columns, row.cells, strict=True)], row.class_)
            for row in (row if isinstance(row, Row) else Row(row) for row in rows)
        ]

    def lines(self, rule: bool = False, header: bool = True) -> list[str]:
        """Lines of text with columns of even widths, the header first; with `rule` a line of hyphens under it."""
        grid = [[column.heading for column in self.columns]] if header else []
        grid += [[cell.plain for cell in row.cells] for row in self.rows]
        widths = [max(map(len, column)) for column in zip(*grid, strict=True)]
        lines = ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in grid]
        if rule:
            lines.insert(1, "  ".join("-" * width for width in widths))
        return lines

    @property
    def markdown(self) -> str:
        """For the docs."""
        grid = [[column.heading for column in self.columns], ["---"] * len(self.columns)]
        grid += [[cell.markdown for cell in row.cells] for row in self.rows]
        return "\n".join(f"| {' | '.join(line)} |" for line in grid)

    @property
    def html(self) -> Markup:
        """For a page, in a frame that scrolls sideways where the window is too narrow."""
        heads = [index for index, column in enumerate(self.columns) if column.head] or [0]
        return _render("table.html", table=self, head=heads[0], missing=MISSING)

    def _repr_html_(self) -> str:
        return self.html
