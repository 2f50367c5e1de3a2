"""Pages of the site that commands of the package write: the page to fly on, and the package's own season."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

SEASON = Path(__file__).parents[1] / "season"  # board.jsonl, and the season's file with its secret told
# Place in the site -> the command that writes it.
COMMANDS = {
    "fly/index.html": ["page", "fly"],
    "season": ["board", "site", str(SEASON), "--season", str(SEASON / "2026-1.json"), "--replays", "1"],
}


def write(app: Sphinx, exception: Exception | None) -> None:
    """Make the pages in processes of their own, as the site's does not compile kernels."""
    if exception is not None or app.builder.format != "html":
        return
    for place, command in COMMANDS.items():
        out = Path(app.outdir, place)
        out.parent.mkdir(exist_ok=True)
        whole = [sys.executable, "-m", "rss_gym", *command, "--out", str(out), "--overwrite"]
        done = subprocess.run(whole, capture_output=True, text=True, check=False)
        if done.returncode:
            raise ExtensionError(f"{place} could not be made: {done.stderr.strip()}")


def setup(app: Sphinx) -> dict[str, bool]:
    """For Sphinx."""
    app.connect("build-finished", write, priority=100)  # before the links are checked
    return {"parallel_read_safe": True}
