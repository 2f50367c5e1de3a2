"""Bars of progress: on a terminal one that moves, elsewhere a line now and then, so that no long work is silent."""

from __future__ import annotations

import sys
from time import monotonic
from typing import Any

from tqdm import tqdm

LINE_S = 30.0  # between two lines


class Lines(tqdm):
    """A bar as lines of their own, for files and pipes; short works print none."""

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        self._last_s = monotonic()
        super().__init__(*arguments, **keywords)

    def display(self, msg: str | None = None, pos: int | None = None) -> None:
        """Print the state, if the last line is old enough."""
        if monotonic() - self._last_s >= LINE_S:
            self._last_s = monotonic()
            print(msg or str(self), file=sys.stderr, flush=True)

    def clear(self, nolock: bool = False) -> None:
        """Nothing is to be cleared."""

    def close(self) -> None:
        """Print nothing more."""
        self.leave = False
        self.disable = True


def progress_bar(show: bool | None = None, **keywords: Any) -> tqdm:
    """A bar of progress.

    Parameters
    ----------
    show : bool, optional
        False for none at all; default: on a terminal a bar, elsewhere a line every half a minute.
    **keywords
        As `tqdm.tqdm` takes them.
    """
    terminal = sys.stderr is not None and sys.stderr.isatty()
    if show or (terminal and show is None):
        return tqdm(**{"leave": False, "dynamic_ncols": True} | keywords)
    return Lines(
        **{"ncols": 100, "ascii": True, "mininterval": 1.0} | keywords | {"disable": show is False, "position": None}
    )
