"""Figures of the pages: drawn with matplotlib, written as SVG that follows the page's colours, light or dark.

Matplotlib comes with the extra `report` and is loaded when the first figure is made.
"""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from rss_gym.pages import colours
from rss_gym.params import ParamsError

# A colour that stands for a variable of the style sheet, and the variable.
_VARIABLES = {
    "#010101": "--ink", "#020202": "--muted", "#030303": "--line", "#040404": "--frame", "#050505": "--paper",
    "#c00000": "--c0", "#c00001": "--c1", "#c00002": "--c2", "#c00003": "--c3", "#c00004": "--c4", "#c00005": "--c5",
    "#c00006": "--c6", "#c00007": "--c7", "#c00008": "--c8", "#c00009": "--nominal",
}  # fmt: skip
INK, MUTED, LINE, FRAME, PAPER, *COLOURS, NOMINAL = _VARIABLES
"""Colours to draw with; `COLOURS` are the nine that tell curves apart."""
CLASSES = {variable[2:]: colour for colour, variable in _VARIABLES.items()}
"""The same by the names of `rss_gym.pages.colours`."""

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none", "svg.hashsalt": "rss_gym", "figure.facecolor": "none", "axes.facecolor": "none",
    "savefig.facecolor": "none", "text.color": INK, "axes.labelcolor": MUTED, "axes.edgecolor": FRAME,
    "axes.titlecolor": INK, "xtick.color": FRAME, "ytick.color": FRAME, "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED, "grid.color": LINE, "axes.grid": True, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "legend.labelcolor": INK,
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 9.0, "axes.titlesize": 9.0,
    "lines.linewidth": 1.4, "path.simplify": True, "path.simplify_threshold": 0.5,
    "figure.constrained_layout.use": True,
}  # fmt: skip


def light() -> dict[str, Any]:
    """The settings of these figures with the colours of the light scheme: `pyplot.rcParams.update(light())`."""
    values = {colour: colours.light()[name] for name, colour in CLASSES.items()}
    settings = {key: values.get(value, value) if isinstance(value, str) else value for key, value in _STYLE.items()}
    return settings | {"figure.facecolor": values[PAPER], "savefig.facecolor": values[PAPER]}


def require_figures() -> None:
    """Check that figures can be drawn; called before a long run, not after it.

    Raises
    ------
    ParamsError
        If matplotlib is missing.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise ParamsError(
            "the figures of this page need matplotlib, which is not installed: pip install -e '.[report]' in the clone"
        ) from error


class Drawing:
    """What `figure` hands out: the axes to draw on, and the markup once the block has ended."""

    def __init__(self, axes: Any) -> None:
        """Keep the axes."""
        self.axes = axes
        self.markup = ""

    @property
    def html(self) -> Markup:
        """The markup for a template or a section."""
        return Markup(self.markup)


@contextmanager
def figure(
    label: str, rows: int = 1, columns: int = 1, width_in: float = 7.0, height_in: float = 3.4, **subplots: Any
) -> Iterator[Drawing]:
    """Draw one figure.

    Parameters
    ----------
    label : str
        What it shows, for readers who do not see it.
    rows, columns : int
        The size of the grid of axes; one by one gives a single axes object.
    width_in, height_in : float
        Size in inches, at 72 pixels each; the page scales it down to its width.
    **subplots
        Further options of `matplotlib.figure.Figure.subplots`.

    Yields
    ------
    Drawing
        `axes` while the block runs; `markup`, and the same as `html`, after it.
    """
    require_figures()
    from cycler import cycler
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(_STYLE | {"axes.prop_cycle": cycler(color=COLOURS)}):
        canvas = Figure(figsize=(width_in, height_in))
        drawing = Drawing(canvas.subplots(rows, columns, **subplots))
        yield drawing
        file = io.StringIO()
        canvas.savefig(file, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    drawing.markup = f'<figure class="plot">{_in_page(file.getvalue(), label)}</figure>'


def _in_page(svg: str, label: str) -> str:
    """The svg element with ids of its own and the page's colours."""
    svg = svg[svg.index("<svg") :]
    for colour, variable in _VARIABLES.items():
        svg = svg.replace(colour, f"var({variable})")
    # Several figures share a page: ids and the references to them tell whose they are, and so do style rules.
    prefix = f"f{hashlib.sha256(svg.encode()).hexdigest()[:8]}-"
    svg = re.sub(r'(\bid="|url\(#|xlink:href="#)', lambda match: match.group(0) + prefix, svg)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL).replace(">*{", ">.plot *{")
    return svg.replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1)


def standalone(markup: str) -> str:
    """A figure's markup as an SVG file of its own, with the page's colours."""
    style = (Path(__file__).parent / "style.css").read_text(encoding="utf-8").partition(".nominal")[0]
    svg = re.sub(r"</?figure[^>]*>", "", markup)
    return re.sub(r"(<svg[^>]*>)", lambda found: f"{found[1]}<style>{style}</style>", svg, count=1)
