"""What each figure gives to the page, and what their drawings share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from rss_gym.eval.paper.number import Number
from rss_gym.pages.figure import COLOURS, MUTED

BLUE, ORANGE, GREEN, VIOLET, RED, *_ = COLOURS


@dataclass(frozen=True)
class Panel:
    """One figure of the page.

    Parameters
    ----------
    title : str
        "Figure 2: ...".
    figure : Markup
        The drawing.
    paper, here : str
        One line each, plain text: what the paper shows and what came out.
    numbers : tuple of Number
    """

    title: str
    figure: Markup
    paper: str
    here: str
    numbers: tuple[Number, ...] = ()


def draw_cdf(axes: Any, errors_m: Any, label: str, colour: str, style: str = "-") -> None:
    """Cumulative distribution of errors, at 400 levels."""
    levels = np.linspace(0.0, 0.995, 400)
    axes.plot(np.quantile(errors_m, levels), levels, color=colour, linestyle=style, label=label)


def finish_cdf(axes: Any, longest_m: float, legend: bool = True) -> None:
    """Axes of error distributions, with the 80 % line that the paper reads them at."""
    axes.axhline(0.8, color=MUTED, linewidth=0.8, linestyle=":")
    axes.set(xlim=(0.0, longest_m), ylim=(0.0, 1.0), xlabel="range error, m", ylabel="share of samples")
    axes.set_yticks([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
    if legend:
        axes.legend(loc="lower right")
