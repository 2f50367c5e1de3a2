"""Studies: what the documents claim and show, flown and printed by `rss-gym study NAME`.

A new study is one module with the two functions of the protocol `study.Study`, and one line in `STUDIES`. That of the
learners stands with them, in a layer above this one.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rss_gym.arguments import count
from rss_gym.params import ParamsError, suggestion

if TYPE_CHECKING:
    from rss_gym.eval.studies.study import Study

# Name -> module, from this package on or in full, and what it answers.
STUDIES: dict[str, tuple[str, str]] = {
    "world": (".world", "whether the radio decides, no blind policy leads, and standard RL learns: docs/world.md"),
    "opponents": (".opponents", "every policy on the same encounters: docs/opponents.md and the README's scores"),
    "learning": ("rss_gym.train.study", "what the recipes learn from scratch, and ablations: docs/learning.md"),
    "roads": (".roads", "the drivers on the highway: docs/roads.md"),
    "paper": (".paper", "the numbers of the paper beside what comes out: docs/paper.md"),
    "calibration": (".calibration.study", "the estimators on recorded radio logs: docs/calibration.md"),
    "readme": (".readme", "the README's picture and example, and the list of docs/agents.md"),
}


def load(name: str) -> Study:
    """The module of a study.

    Raises
    ------
    ParamsError
        For an unknown name, with the nearest known one.
    """
    if name not in STUDIES:
        raise ParamsError(f"study {name!r} is unknown{suggestion(name, STUDIES)}")
    study: Study = importlib.import_module(STUDIES[name][0], __name__)
    return study


def run(name: str, arguments: Sequence[str] = ()) -> None:
    """Run a study: print its parts one after another and, with `--pages`, put each into its page.

    Raises
    ------
    ParamsError
        For an unknown study or what it cannot do.
    """
    study = load(name)
    from rss_gym.eval.studies.study import RUNS

    parser = argparse.ArgumentParser(prog=f"rss-gym study {name}", description=f"Study: {STUDIES[name][1]}.")
    parser.add_argument("--workers", type=count, default=2, metavar="N", help="processes (default: 2)")
    parser.add_argument(
        "--pages", type=Path, metavar="ROOT", help="root of a clone whose pages are written (default: print only)"
    )
    parser.add_argument("--runs", type=Path, default=RUNS, metavar="DIR", help=f"folder of records (default: {RUNS})")
    study.add_arguments(parser)
    options = parser.parse_args(arguments)
    if options.pages is not None and not (options.pages / "docs").is_dir():  # before hours of flights, not after them
        raise ParamsError(f"--pages {str(options.pages)!r} must be the root of a clone, a folder with docs/ in it")
    for part in study.run(options):
        print(part.text, flush=True)
        if options.pages is not None:  # after each: an interrupted study keeps what it has flown
            part.put(options.pages)
