"""The table of the drivers in docs/roads.md, and its picture: `python docs/highway.py [--record DIR]`.

Without `--record` it drives each policy first, agents that are shipped too: 1,000 episodes take a quarter of an hour on
two cores. `--ship RUN NAME` only puts the driver of a finished run, with its card, into baselines/road/agents/NAME/.
"""

import argparse
import os
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import opponents
from PIL import Image, ImageDraw, ImageFont

from rss_gym.baselines.road import AGENTS, FOLDER, World, make
from rss_gym.eval import road
from rss_gym.eval.policies import folder_name
from rss_gym.eval.text import cell
from rss_gym.files import replaced_folder, write_text
from rss_gym.highway.env import RoadEnv
from rss_gym.train.road.run import CARD
from rss_gym.train.run_record import AGENT, copy_policy

ROOT = Path(__file__).resolve().parent.parent
SUITE, POLICIES = "highway-v0", ("none", "rule", "idm", *AGENTS)
COLUMNS = {
    "cost_m": ("cost, m", ".1f"),
    "collision_rate": ("collisions", ".3f"),
    "snmac_rate": ("near misses", ".3f"),
    "path_deviation_mean_m": ("mean deviation, m", ".1f"),
    "lane_deviation_m": ("off the planned lane, m", ".2f"),
    "speed_deviation_mps": ("off the planned speed, m/s", ".2f"),
}
SHOWN_EPISODE, SHOWN_DECISION = 0, 5
SCALING, WIDTH_PX, HEIGHT_PX = 11.0, 1200, 240
WARNED, QUIET, INK = (225, 40, 40), (60, 130, 230), (255, 255, 255)


def table(record: Path) -> str:
    """The rows of a record in Markdown."""
    rows = []
    for row in sorted(opponents.read([record]).values(), key=lambda row: row.metrics["cost_m"].value):
        cells = [cell(row.metrics[name], 1.0, form) for name, (_, form) in COLUMNS.items()]
        rows.append([f"`{folder_name(row.spec) if '/' in row.spec else row.spec}`", str(row.episodes), *cells])
    titles = ["policy", "episodes", *(title for title, _ in COLUMNS.values())]
    made = opponents.made(command="python docs/highway.py")
    return f"{opponents.table(titles, rows)}\n\n{made.removesuffix('.')}, highway-env {version('highway-env')}."


def ship(run: Path, name: str, into: Path = FOLDER) -> Path:
    """Make the folder of a shipped driver from a run of `rss-gym train`, in place of an older one."""
    into.mkdir(exist_ok=True)
    with replaced_folder(into / name) as folder:
        copy_policy(run / AGENT, folder)
        text = (run / AGENT / CARD).read_text(encoding="utf-8")
        write_text(folder / CARD, re.sub("(?<=^# Driver `)[^`]+", name, text))
    return into / name


def picture() -> Image.Image:
    """A frame of the rule on its way: rings of the estimated ranges, red while the warning is open."""
    view = {"screen_width": WIDTH_PX, "screen_height": HEIGHT_PX, "scaling": SCALING, "centering_position": [0.2, 0.5]}
    env = RoadEnv(render_mode="rgb_array", config=view)
    observation, _ = env.reset(seed=0, options={"split": "suite", "episode": SHOWN_EPISODE})
    policy = make("rule", World.of(env))
    for _ in range(SHOWN_DECISION):
        observation, *_ = env.step(policy.predict(observation)[0])
    image = Image.fromarray(env.render())
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    centre = np.array([0.2 * WIDTH_PX, 0.5 * HEIGHT_PX])
    _, others = env.ranging.sensor.sense()
    for k, other in enumerate(others[:4]):
        ring(draw, font, centre, other, 14 + 18 * (k % 2))
    env.close()
    return image


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


def main() -> None:
    """Drive if need be, and write table and picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--record", type=Path, help="a record of `rss-gym eval --suite highway-v0`, in place of driving"
    )
    parser.add_argument("--policy", nargs="+", default=list(POLICIES), help="what to drive, agents' folders too")
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--ship", nargs=2, metavar=("RUN", "NAME"), help="ship a driver and do nothing else")
    options = parser.parse_args()
    if options.ship:
        print(ship(Path(options.ship[0]), options.ship[1]))
        return
    os.environ.pop("SDL_VIDEODRIVER", None)  # with the driver `dummy` highway-env draws nothing
    picture().save(ROOT / "docs" / "highway.png", optimize=True)
    record = options.record or road.save(
        road.evaluate(options.policy, SUITE, options.episodes, workers=options.workers),
        ROOT / "runs" / "highway-scores",
    )
    opponents.put(ROOT / "docs" / "roads.md", "road", table(record))


if __name__ == "__main__":
    main()
