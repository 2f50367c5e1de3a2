"""Ships a driver: puts the policy of a finished run, with its card, into `baselines/road/agents/NAME/`.

python -m rss_gym.train.road.ship RUN NAME
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from rss_gym.baselines.road import FOLDER
from rss_gym.baselines.shipped import CARD
from rss_gym.files import replaced_folder, write_text
from rss_gym.train.run_record import AGENT, copy_policy


def ship(run: Path, name: str, into: Path = FOLDER) -> Path:
    """Make the folder of a shipped driver from a run of `rss-gym train`, in place of an older one."""
    into.mkdir(exist_ok=True)
    with replaced_folder(into / name) as folder:
        copy_policy(run / AGENT, folder)
        text = (run / AGENT / CARD).read_text(encoding="utf-8")
        write_text(folder / CARD, re.sub("(?<=^# Driver `)[^`]+", name, text))
    return into / name


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Makes the folder of a shipped driver from a finished run.")
    parser.add_argument("run", type=Path, metavar="RUN")
    parser.add_argument("name", metavar="NAME")
    options = parser.parse_args()
    print(ship(options.run, options.name))


if __name__ == "__main__":
    main()
