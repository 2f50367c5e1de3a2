"""What the shells hold for rendering: histories of the rows to draw, and the window. Idle without a render mode."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded

from rss_gym.params import ParamsError, suggestion
from rss_gym.render.frame import draw
from rss_gym.render.recorder import RENDER_FPS, Recorder
from rss_gym.render.window import Window

__all__ = ["RENDER_FPS", "Painter"]


class Painter:
    """Frames of the rows of a batch.

    Parameters
    ----------
    mode : str or None
        A render mode of `metadata`; None records and draws nothing. With `rgb_array_list` every frame is drawn, and
        kept until it is asked for or the row's next episode begins, as `gymnasium.wrappers.RenderCollection` does.
    metadata : dict
        The environment's.
    rows : int
        Rows to record.
    """

    def __init__(self, mode: str | None, metadata: dict[str, Any], rows: int = 1) -> None:
        if mode is not None and mode not in metadata["render_modes"]:
            raise ParamsError(f"render_mode {mode!r} is unknown{suggestion(str(mode), metadata['render_modes'])}")
        self.mode = mode
        self.recorders = [] if mode is None else [Recorder() for _ in range(rows)]
        self.window: Window | None = None
        self._frames: list[list[np.ndarray]] = [[] for _ in self.recorders]

    def restart(self, batch: Any, mask: np.ndarray | None = None) -> None:
        """Forget the history of the rows of `mask` (default: all): a new episode begins."""
        for row, recorder in enumerate(self.recorders):
            if mask is None or mask[row]:
                recorder.reset(batch, row)
                self._frames[row].clear()
                self._keep(batch, row)
        self._show(batch)

    def follow(self, batch: Any, mask: np.ndarray | None = None) -> None:
        """Add the decision just flown to the history of the rows of `mask` (default: all)."""
        for row, recorder in enumerate(self.recorders):
            if mask is None or mask[row]:
                recorder.append(batch, row)
                self._keep(batch, row)
        self._show(batch)

    def render(self, batch: Any) -> np.ndarray | None:
        """Frame of row 0 for `rgb_array`; None for `human`, whose window is refreshed at every step."""
        return self.render_row(batch, 0) if self.mode == "rgb_array" else None

    def render_all(self, batch: Any) -> tuple[Any, ...] | None:
        """What `render_row` gives of each row, or None without a render mode."""
        return tuple(self.render_row(batch, row) for row in range(len(self.recorders))) if self.recorders else None

    def render_row(self, batch: Any, row: int) -> Any:
        """The row's frame, (H, W, 3); the list of those since it was last asked for; or None without a render mode.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the row's first reset.
        """
        if self.mode is None:
            return None
        if not batch.started[row]:
            raise ResetNeeded("call reset() before render(): no episode is running")
        if self.mode == "rgb_array_list":
            frames, self._frames[row] = self._frames[row], []
            return frames
        return self._frame(batch, row)

    def close(self) -> None:
        """Close the window."""
        if self.window is not None:
            self.window.close()
            self.window = None

    def _frame(self, batch: Any, row: int) -> np.ndarray:
        return draw(self.recorders[row].scene(batch, row))

    def _keep(self, batch: Any, row: int) -> None:
        if self.mode == "rgb_array_list":
            self._frames[row].append(self._frame(batch, row))

    def _show(self, batch: Any) -> None:
        if self.mode != "human":
            return
        if self.window is None:
            self.window = Window()
        self.window.show(self._frame(batch, 0), RENDER_FPS)
