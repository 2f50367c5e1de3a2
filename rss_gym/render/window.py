"""A window that shows frames on the screen, for `render_mode="human"`.

pygame is imported when the first frame is shown, not when this module is.
"""

from __future__ import annotations

import os
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Window"]


class Window:
    """Shows one frame after another, at a given rate.

    A window closed by its user stays closed: `show` then returns at once, and the flight goes on unseen.

    Attributes
    ----------
    is_closed : bool
        True after `close`, or once the user has closed the window.
    is_unseen : bool
        Whether what is shown goes to no screen, because there is none.
    """

    def __init__(self, title: str = "rss_gym") -> None:
        self.is_closed = False
        self.is_unseen = False
        self._title = title
        self._screen: Any = None
        self._clock: Any = None

    def show(self, frame: NDArray[np.uint8], fps: float) -> None:
        """Show a frame, wait until it is due, and answer the events of the window.

        Parameters
        ----------
        frame : array (height, width, 3) of uint8
            A new size resizes the window.
        fps : float
            Frames per second [1/s]; the call waits until 1 / fps has passed since the frame before. 0: no waiting.
        """
        if frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != np.uint8:
            raise ValueError(f"frame is {frame.dtype} of shape {frame.shape}; expected uint8 of (height, width, 3)")
        if not 0 <= fps < float("inf"):
            raise ValueError(f"fps is {fps}; expected a finite number, 0 or more")
        if self.is_closed:
            return
        pygame = _pygame()
        size_px = (frame.shape[1], frame.shape[0])
        if self._screen is None:
            pygame.display.init()
            pygame.display.set_caption(self._title)
            self.is_unseen = pygame.display.get_driver() in ("dummy", "offscreen")
            self._clock = pygame.time.Clock()
        if self._screen is None or self._screen.get_size() != size_px:
            self._screen = pygame.display.set_mode(size_px)
        self._screen.blit(pygame.image.frombuffer(frame.tobytes(), size_px, "RGB"), (0, 0))
        pygame.display.flip()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()
            return
        self._clock.tick(fps)

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self._screen is not None:
            _pygame().display.quit()
            self._screen = None
        self.is_closed = True


def _pygame() -> ModuleType:
    """The module pygame, imported when first needed and without its greeting."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        import pygame
    except ImportError as error:
        from gymnasium.error import DependencyNotInstalled

        raise DependencyNotInstalled("A window needs pygame: pip install -e '.[render]' in the clone") from error
    return pygame
