"""Every figure of a page: drawn with matplotlib, written as SVG that follows the page's colours, light or dark.

Matplotlib is loaded when the first figure is made.
"""

from __future__ import annotations

import hashlib
import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from rss_gym.pages import colours

# A colour that stands for a variable of the style sheet, and the variable.
_VARIABLES = {
    "#010101": "--ink", "#020202": "--muted", "#030303": "--line", "#040404": "--frame", "#050505": "--paper",
    "#060606": "--red",
    "#c00000": "--c0", "#c00001": "--c1", "#c00002": "--c2", "#c00003": "--c3", "#c00004": "--c4", "#c00005": "--c5",
    "#c00006": "--c6", "#c00007": "--c7", "#c00008": "--c8", "#c00009": "--nominal",
}  # fmt: skip
INK, MUTED, LINE, FRAME, PAPER, RED, *COLOURS, NOMINAL = _VARIABLES
"""Colours to draw with; `COLOURS` are the nine that tell curves apart."""
CLASSES = {variable[2:]: colour for colour, variable in _VARIABLES.items()} | {"fault": RED}
"""The same by the names of `rss_gym.pages.colours`, and that of a policy with faults."""

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
    values = {colour: colours.light()[variable[2:]] for colour, variable in _VARIABLES.items()}
    settings = {key: values.get(value, value) if isinstance(value, str) else value for key, value in _STYLE.items()}
    return settings | {"figure.facecolor": values[PAPER], "savefig.facecolor": values[PAPER]}


class Drawing:
    """What `figure` hands out: the axes to draw on, and the markup once the block has ended."""

    def __init__(self, axes: Any) -> None:
        """Keep the axes."""
        self.axes = axes
        self.markup = ""
        self.tips: dict[str, str] = {}

    def tip(self, axes: Any, x: float, y: float, text: str) -> None:
        """Show a text where the pointer is over a point, and read it to those who do not see the figure."""
        name = f"tip-{len(self.tips)}"
        self.tips[name] = text
        axes.plot(x, y, "o", markersize=18.0, alpha=0.0, gid=name)

    @property
    def html(self) -> Markup:
        """The markup for a template or a section."""
        return Markup(self.markup)


@contextmanager
def figure(
    label: str,
    rows: int = 1,
    columns: int = 1,
    width_in: float = 7.0,
    height_in: float = 3.4,
    class_: str = "",
    **subplots: Any,
) -> Iterator[Drawing]:
    """Draw one figure.

    Parameters
    ----------
    label : str
        What it shows, for readers who do not see it.
    rows, columns : int
        The size of the grid of axes; one by one gives a single axes object.
    width_in, height_in : float
        Size in inches, at 96 pixels each; the page scales it down to its width.
    class_ : str
        `wide`, `medium` or `narrow` where a figure is drawn in three sizes: the page shows the one that fits.
    **subplots
        Further options of `matplotlib.figure.Figure.subplots`.

    Yields
    ------
    Drawing
        `axes` while the block runs; `markup`, and the same as `html`, after it.
    """
    from cycler import cycler
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(_STYLE | {"axes.prop_cycle": cycler(color=COLOURS)}), warnings.catch_warnings():
        # The letters of a name are the browser's, whatever matplotlib's own typeface lacks.
        warnings.filterwarnings("ignore", message="Glyph")
        canvas = Figure(figsize=(width_in, height_in))
        drawing = Drawing(canvas.subplots(rows, columns, **subplots))
        yield drawing
        file = io.StringIO()
        canvas.savefig(file, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    svg = file.getvalue()
    for name, text in drawing.tips.items():
        svg = svg.replace(f'<g id="{name}">', f'<g id="{name}"><title>{escape(text)}</title>', 1)
    drawing.markup = f'<figure class="{f"plot {class_}".strip()}">{_in_page(svg, label)}</figure>'


def _in_page(svg: str, label: str) -> str:
    """The svg element with ids of its own and the page's colours."""
    svg = svg[svg.index("<svg") :]
    for colour, variable in _VARIABLES.items():
        svg = svg.replace(colour, f"var({variable})")
    # Several figures share a page: ids and the references to them tell whose they are, and so do style rules.
    prefix = f"f{hashlib.sha256(svg.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}-"
    svg = re.sub(r'(\bid="|url\(#|xlink:href="#)', lambda match: match.group(0) + prefix, svg)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL).replace(">*{", ">.plot *{")
    return svg.replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1)


def standalone(markup: str) -> str:
    """A figure's markup as an SVG file of its own, with the page's colours."""
    style = (Path(__file__).parent / "style.css").read_text(encoding="utf-8").partition(".nominal")[0]
    svg = re.sub(r"</?figure[^>]*>", "", markup)
    return re.sub(r"(<svg[^>]*>)", lambda found: f"{found[1]}<style>{style}</style>", svg, count=1)
