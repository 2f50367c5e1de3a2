"""`rss-gym record`: a film or a picture of policies that fly the same encounter."""

from __future__ import annotations

import argparse
import os
from typing import Any

from rss_gym.arguments import count

HELP = "write a video, an animation or a picture of policies that fly the same encounter side by side"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_flight(parser)
    parser.add_argument(
        "--out",
        required=True,
        metavar="FILE",
        help="new file: .mp4, .gif, or .png for the moment of the least distance",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace an older file of that name")
    parser.add_argument(
        "--every",
        type=count,
        default=1,
        metavar="N",
        help="decisions between frames; more make a smaller file (default: 1)",
    )


def add_flight(parser: argparse.ArgumentParser) -> None:
    """What is flown, and how wide it is drawn."""
    from rss_gym.ids import IDS

    parser.add_argument(
        "--policy", nargs="+", required=True, metavar="NAME|FOLDER", help="policies, drawn from left to right"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the encounter (default: 0)")
    parser.add_argument(
        "--env",
        choices=list(IDS),
        default="rss_gym/Encounter-v0",
        metavar="ID",
        help="environment (default: rss_gym/Encounter-v0)",
    )
    parser.add_argument(
        "--set", nargs="+", action="extend", metavar="KEY=VALUE", help="parameters of the world, such as intruders=2"
    )
    parser.add_argument(
        "--width", type=count, default=640, metavar="PIXELS", help="width of the picture of a flight (default: 640)"
    )


def run(options: argparse.Namespace) -> None:
    """Fly and write the file."""
    from rss_gym.params import ParamsError
    from rss_gym.render import film

    film.require(film.suffix(options.out))
    if os.path.exists(options.out) and not options.overwrite:
        raise ParamsError(f"--out {options.out!r} exists already; give another name or --overwrite")
    flown = flights(options, options.seed)
    for flight in flown:
        print(f"{flight.name}: {flight.outcome}")
    print(f"recorded: {film.save(flown, options.out, options.width, options.every)}")


def flights(options: argparse.Namespace, seed: int) -> list[Any]:
    """The flights of the encounter of that seed, one for each policy."""
    import gymnasium as gym

    from rss_gym.commands.shared import see_modules_here
    from rss_gym.eval.policies import entry
    from rss_gym.ids import IDS
    from rss_gym.params import Params
    from rss_gym.render import film
    from rss_gym.train.recipe import parse_changes

    see_modules_here()
    world = Params.of(**{**IDS[options.env], **parse_changes(options.set or [])})
    entries = [entry(policy, world) for policy in options.policy]
    flown = []
    for one in entries:
        env = gym.make(options.env, params=one.params, disable_env_checker=True)
        flown.append(film.fly(env, one.policy, one.name, seed))
        env.close()
    return flown
