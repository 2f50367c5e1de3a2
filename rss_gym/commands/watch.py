"""`rss-gym watch`: policies that fly one encounter after another, in a window."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from rss_gym.arguments import count
from rss_gym.commands.record import add_flight, flights

HELP = "show policies that fly the same encounters side by side, in a window or, without a display, in a file"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_flight(parser)
    parser.add_argument(
        "--encounters",
        type=count,
        metavar="N",
        help="number of encounters, by the seed and those after it (default: until the window is closed)",
    )


def run(options: argparse.Namespace) -> None:
    """Show one encounter after another until the window is closed; without one, write the first to a file."""
    from gymnasium.error import DependencyNotInstalled

    from rss_gym.render import film
    from rss_gym.render.recorder import RENDER_FPS
    from rss_gym.render.window import Window

    film.require()
    window, seed = Window("rss-gym watch: close the window to end"), options.seed
    while options.encounters is None or seed < options.seed + options.encounters:
        flown = flights(options, seed)
        print(f"encounter {seed}: " + "; ".join(f"{flight.name} {flight.outcome}" for flight in flown), flush=True)
        try:
            for frame in film.frames(flown, options.width, 1):
                window.show(frame, RENDER_FPS)
                if window.is_closed:
                    return
                if window.is_unseen:
                    raise RuntimeError("there is no display")
        except (DependencyNotInstalled, RuntimeError) as error:  # pygame.error is a RuntimeError
            file = Path(tempfile.mkdtemp(prefix="rss-gym-watch-")) / f"encounter-{seed}.gif"
            print(f"No window can be opened ({error}); the encounter is written to a file.", file=sys.stderr)
            print(f"recorded: {film.save(flown, str(file), options.width, 2)}")
            return
        seed += 1
    window.close()
