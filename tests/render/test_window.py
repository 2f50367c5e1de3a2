"""The window: `rss_gym.render.window`."""

import sys
import time

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from rss_gym.render.window import Window


def picture(width, height):
    return np.random.default_rng(1).integers(0, 256, (height, width, 3), dtype=np.uint8)


def test_a_missing_pygame_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r"pygame: pip install -e '\.\[render\]'"):
        Window().show(picture(400, 300), 30)


@pytest.fixture
def pygame(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setenv("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    return pytest.importorskip("pygame", reason="needs the extra `render`")


def test_the_window_shows_the_frame(pygame):
    window = Window()
    frame = picture(400, 300)
    window.show(frame, 0)
    assert pygame.display.get_caption()[0] == "rss_gym"
    shown = pygame.surfarray.array3d(pygame.display.get_surface())
    assert np.array_equal(shown.swapaxes(0, 1), frame)
    window.show(picture(640, 480), 0)
    assert pygame.display.get_surface().get_size() == (640, 480)
    window.close()
    window.close()
    assert window.is_closed and not pygame.display.get_init()


def test_the_window_keeps_the_rate(pygame):
    window, frame = Window(), picture(400, 300)
    window.show(frame, 50)
    start = time.perf_counter()
    for _ in range(5):
        window.show(frame, 50)
    window.close()
    assert time.perf_counter() - start > 0.08


def test_a_window_closed_by_its_user_stays_closed(pygame):
    window, frame = Window(), picture(400, 300)
    window.show(frame, 0)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    window.show(frame, 0)
    assert window.is_closed
    window.show(frame, 0)
    assert not pygame.display.get_init()


@pytest.mark.parametrize(("frame", "fps"), [(np.zeros((4, 4)), 30), (np.zeros((4, 4, 3)), 30)])
def test_a_wrong_frame_is_refused(frame, fps):
    with pytest.raises(ValueError, match="frame"):
        Window().show(frame, fps)


@pytest.mark.parametrize("fps", [-1.0, float("nan"), float("inf")])
def test_a_wrong_rate_is_refused(fps):
    with pytest.raises(ValueError, match="fps"):
        Window().show(np.zeros((4, 4, 3), np.uint8), fps)
