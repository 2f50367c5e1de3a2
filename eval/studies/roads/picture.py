"""The picture of docs/roads.md."""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rss_gym.baselines import make
from rss_gym.highway.env import RoadEnv

SHOWN_EPISODE, SHOWN_DECISION = 0, 5
SCALING, WIDTH_PX, HEIGHT_PX = 11.0, 1200, 240
WARNED, QUIET, INK = (225, 40, 40), (60, 130, 230), (255, 255, 255)


def picture() -> bytes:
    """A frame of the rule on its way: rings of the estimated ranges, red while the warning is open."""
    os.environ.pop("SDL_VIDEODRIVER", None)  # with the driver `dummy` highway-env draws nothing
    view = {"screen_width": WIDTH_PX, "screen_height": HEIGHT_PX, "scaling": SCALING, "centering_position": [0.2, 0.5]}
    env = RoadEnv(render_mode="rgb_array", config=view)
    observation, _ = env.reset(seed=0, options={"split": "suite", "episode": SHOWN_EPISODE})
    policy = make("rule", env.params)
    for _ in range(SHOWN_DECISION):
        observation, *_ = env.step(policy.predict(observation)[0])
    image = Image.fromarray(env.render())
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    centre = np.array([0.2 * WIDTH_PX, 0.5 * HEIGHT_PX])
    _, others = env.ranging.sensor.sense()
    for k, other in enumerate(others[:4]):
        ring(draw, font, centre, other, 14 + 18 * (k % 2))
    env.close()
    file = io.BytesIO()
    image.save(file, "png", optimize=True)
    return file.getvalue()


def ring(draw: Any, font: Any, centre: np.ndarray, other: np.ndarray, label_px: float) -> None:
    """The ring of an estimated range, with its standard deviation, and its label."""
    colour = WARNED if other["warning"] else QUIET
    radius_px = SCALING * float(other["range_m"])
    box = [*(centre - radius_px), *(centre + radius_px)]
    draw.ellipse(box, outline=colour, width=3 if other["warning"] else 2)
    label_px = max(label_px, centre[1] - radius_px - 20.0)  # of a small ring, above it
    x = centre[0] + np.sqrt(max(radius_px**2 - (centre[1] - label_px) ** 2, 0.0))
    text = f"{float(other['range_m']):.0f} ± {float(other['range_std_m']):.0f} m"
    if x + 90 < WIDTH_PX:
        draw.text((x + 6, label_px), text, fill=INK, font=font)
