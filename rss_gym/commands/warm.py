"""`rss-gym warm`: compile the kernels before they are needed, as in the image of a container."""

from __future__ import annotations

import argparse

KEPT = "what was compiled before is kept"
HELP = "compile the kernels before they are needed, and say where they are kept"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""


def run(options: argparse.Namespace) -> int:
    """Compile, under the lock of the cache; 1 if nothing can be kept."""
    from rss_gym.warm import warm

    folder = warm()
    if folder is None:
        return 1
    size = sum(path.stat().st_size for path in folder.rglob("*.nb[ic]"))
    print(f"compiled kernels: {folder} ({size / 1e6:.1f} MB)")
    return 0
