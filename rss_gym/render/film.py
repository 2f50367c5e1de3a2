"""Flights side by side: what each policy does in the same encounter, as frames, a video, an animation or a still."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rss_gym.files import write_bytes
from rss_gym.params import ParamsError, suggestion
from rss_gym.render.canvas import Canvas, pillow
from rss_gym.render.frame import SMALLEST_PX, draw
from rss_gym.render.recorder import RENDER_FPS, Recorder
from rss_gym.render.scene import Scene
from rss_gym.render.style import INK, MUTED, PANEL

__all__ = ["SUFFIXES", "Flight", "animated", "beside", "fly", "frames", "nearest", "require", "save", "suffix"]

SUFFIXES = (".mp4", ".gif", ".png")
COLOURS = 64  # of an animation: the drawings have few, and each more costs bytes
PAUSE_S = 2.0  # on the last frame of an animation
_TITLE_PX = 34


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """One policy's flight of an encounter.

    Attributes
    ----------
    name : str
        The name of the policy.
    scenes : list of Scene
        The start, and the moment after each decision.
    cost_m : float
        Cost of the encounter [m].
    collision : bool
    """

    name: str
    scenes: list[Scene]
    cost_m: float
    collision: bool

    @property
    def outcome(self) -> str:
        """How it ended, for the title."""
        return f"cost {self.cost_m:,.1f} m" + (", collision" if self.collision else "")


def fly(env: Any, policy: Any, name: str, seed: int) -> Flight:
    """Fly one encounter to its end.

    Parameters
    ----------
    env : gymnasium.Env
        An encounter environment.
    policy : object
        With the `predict` of Stable-Baselines3.
    name : str
        For the title.
    seed : int
        The seed of the encounter; the same one gives every policy the same.
    """
    recorder = Recorder()
    batch = env.unwrapped.batch
    observation, info = env.reset(seed=seed)
    recorder.reset(batch, 0)
    scenes = [recorder.scene(batch, 0)]
    state, start, done = None, np.ones(1, bool), False
    while not done:
        action, state = policy.predict(observation[None], state, start, deterministic=True)
        observation, _, terminated, truncated, info = env.step(np.asarray(action)[0])
        recorder.append(batch, 0)
        scenes.append(recorder.scene(batch, 0))
        start, done = np.zeros(1, bool), terminated or truncated
    return Flight(name, scenes, float(info["cost_m"]), bool(info["collision"]))


def nearest(flight: Flight) -> int:
    """The scene in which an intruder is nearest."""

    def separation(scene: Scene) -> float:
        gaps = (np.linalg.norm(other.position_m - scene.own.position_m) for other in scene.intruders)
        return float(min(gaps, default=np.inf))

    return int(np.argmin([separation(scene) for scene in flight.scenes]))


def beside(flights: Sequence[Flight], index: int, width_px: int) -> NDArray[np.uint8]:
    """A frame with one picture for each flight, its policy above it.

    Parameters
    ----------
    flights : sequence of Flight
        One that is over stays at its end.
    index : int
        The number of the scene.
    width_px : int
        Width of a picture, at least 400; its height is three quarters of that.

    Returns
    -------
    array (height, width, 3) of uint8
        Both are even, as video needs it.
    """
    if width_px < SMALLEST_PX[0]:
        raise ParamsError(f"--width {width_px} is too small: a picture is at least {SMALLEST_PX[0]} pixels wide")
    width, height = width_px // 2 * 2, width_px * 3 // 8 * 2
    pictures = [_titled(flight, index, (width, height)) for flight in flights]
    return np.concatenate(pictures, axis=1)


def _titled(flight: Flight, index: int, size_px: tuple[int, int]) -> NDArray[np.uint8]:
    over = index >= len(flight.scenes) - 1
    picture = draw(flight.scenes[min(index, len(flight.scenes) - 1)], size_px)
    image = pillow("Image").new("RGB", (size_px[0], _TITLE_PX), PANEL)
    title = Canvas((size_px[0], _TITLE_PX), 1.0, PANEL)
    title.text(np.array([10, _TITLE_PX / 2]), flight.name, INK, "lm")
    if over:
        title.text(np.array([size_px[0] - 10, _TITLE_PX / 2]), flight.outcome, MUTED, "rm")
    title.place(image, (0, 0))
    return np.concatenate([np.asarray(image, dtype=np.uint8), picture])


def require(kind: str = ".png") -> None:
    """What files of this kind are drawn and written with.

    Raises
    ------
    ParamsError
        If it is not installed.
    """
    needed = {"PIL": "Pillow"} | ({"moviepy": "MoviePy"} if kind == ".mp4" else {})
    missing = [name for module, name in needed.items() if find_spec(module) is None]
    if missing:
        what = "a video" if kind == ".mp4" else "drawing"
        raise ParamsError(f"{what} needs {' and '.join(missing)}: pip install -e '.[render]' in the clone")


def suffix(path: str) -> str:
    """The kind of a file by its name.

    Raises
    ------
    ParamsError
        If it is none that can be written.
    """
    kind = Path(path).suffix.lower()
    if kind not in SUFFIXES:
        raise ParamsError(f"--out {path!r} must end with {', '.join(SUFFIXES)}{suggestion(kind, SUFFIXES)}")
    return kind


def frames(flights: Sequence[Flight], width_px: int, every: int) -> Iterator[NDArray[np.uint8]]:
    """Frames from the start to the end of the longest flight, one every so many decisions, the last included."""
    last = max(len(flight.scenes) for flight in flights) - 1
    for index in sorted({*range(0, last, every), last}):
        yield beside(flights, index, width_px)


def save(flights: Sequence[Flight], path: str, width_px: int = 640, every: int = 1) -> Path:
    """Write a video (.mp4), an animation (.gif), or a picture of the first flight's least distance (.png).

    Parameters
    ----------
    flights : sequence of Flight
    path : str
    width_px : int
        Width of the picture of a flight.
    every : int
        Decisions between frames. The speed stays the same.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ParamsError
        For another ending of the name, or without Pillow or, for a video, MoviePy.
    """
    kind = suffix(path)
    require(kind)
    if kind == ".png":
        content = _png(beside(flights, nearest(flights[0]), width_px))
    elif kind == ".gif":
        content = animated(frames(flights, width_px, every), every)
    else:
        content = _mp4(list(frames(flights, width_px, every)), every)
    return write_bytes(path, content)


def _png(frame: NDArray[np.uint8]) -> bytes:
    file = io.BytesIO()
    pillow("Image").fromarray(frame).save(file, "png", optimize=True)
    return file.getvalue()


def animated(pictures: Iterator[NDArray[np.uint8]], every: int) -> bytes:
    """A GIF of frames that are so many decisions apart.

    All have the most frequent colours of the first, the middle and the last one, so that what stays the same is stored
    once.
    """
    images = [pillow("Image").fromarray(frame) for frame in pictures]
    chosen = np.concatenate([np.asarray(images[at]).reshape(-1, 3) for at in (0, len(images) // 2, -1)])
    colours, counts = np.unique(chosen, axis=0, return_counts=True)
    palette = pillow("Image").new("P", (1, 1))
    palette.putpalette(colours[np.argsort(-counts, kind="stable")[:COLOURS]].ravel().tolist())
    reduced = [image.quantize(palette=palette, dither=0) for image in images]
    pause = [round(1000 * every / RENDER_FPS)] * (len(reduced) - 1) + [round(1000 * PAUSE_S)]
    file = io.BytesIO()
    reduced[0].save(
        file, "gif", save_all=True, append_images=reduced[1:], duration=pause, loop=0, optimize=False, disposal=1
    )
    return file.getvalue()


def _mp4(pictures: list[NDArray[np.uint8]], every: int) -> bytes:
    from moviepy import ImageSequenceClip

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "video.mp4"
        clip = ImageSequenceClip(pictures, fps=RENDER_FPS / every)
        clip.write_videofile(str(file), codec="libx264", audio=False, logger=None)
        return file.read_bytes()
