"""The paper's figures and numbers, computed by this package beside what the paper states: `rss-gym paper`."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rss_gym.eval.paper import page
from rss_gym.eval.paper.figures import FIGURES
from rss_gym.eval.paper.number import Number
from rss_gym.eval.paper.panel import Panel
from rss_gym.eval.paper.study import QUICK, Size, Study
from rss_gym.files import new_folder, write_text
from rss_gym.params import ParamsError
from rss_gym.progress import progress_bar

__all__ = ["FIGURES", "QUICK", "Number", "Reproduction", "Size", "reproduce", "write"]

NUMBERS, PAGE = "paper.json", "index.html"
SEED_END = 2**31  # the figures make keys of their own from the seed


@dataclass(frozen=True)
class Reproduction:
    """All figures with their numbers."""

    study: Study
    panels: tuple[Panel, ...]

    @property
    def numbers(self) -> tuple[Number, ...]:
        """Of all figures, in the order of the page."""
        return tuple(number for panel in self.panels for number in panel.numbers)

    @property
    def summary(self) -> str:
        """How many numbers agree, in one sentence."""
        return page.summary(self.numbers)


def reproduce(size: Size | None = None, seed: int = 0, progress: bool | None = None) -> Reproduction:
    """Compute every figure; the same size and seed give the same numbers.

    Parameters
    ----------
    size : Size, optional
        How much is run; default: the full size. `QUICK` has intervals too wide to show the small probabilities.
    seed : int
        The seed of all noise, in [0, 2**31).
    progress : bool, optional
        Show a progress bar; default: when the error stream is a terminal.

    Raises
    ------
    ParamsError
        For a seed out of range.
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < SEED_END:
        raise ParamsError(f"seed must be a whole number in [0, {SEED_END}), got {seed!r}")
    study = Study(size or Size(), seed)
    with progress_bar(progress, iterable=FIGURES.items(), unit="figure") as bar:
        panels = []
        for name, draw in bar:
            bar.set_description(f"figure {name}")
            panels.append(draw(study))
    return Reproduction(study, tuple(panels))


def write(reproduction: Reproduction, out: str | os.PathLike[str]) -> Path:
    """Write `paper.json` and `index.html` into a new folder.

    Raises
    ------
    ParamsError
        If the folder exists and is not empty, or cannot be written.
    """
    with new_folder(out) as folder:
        write_text(folder / NUMBERS, to_json(reproduction.numbers))
        write_text(folder / PAGE, page.markup(reproduction.study, reproduction.panels))
    return Path(out)


def to_json(numbers: Sequence[Number]) -> str:
    """The list of `paper.json`."""
    return json.dumps([number.to_dict() for number in numbers], indent=1, ensure_ascii=False, allow_nan=False) + "\n"
