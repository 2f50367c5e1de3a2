"""The page on which a person flies against the shipped agent, written into the site at `fly/index.html`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

PLACE = "fly/index.html"


def write(app: Sphinx, exception: Exception | None) -> None:
    """Make the page in a process of its own, as the site's does not compile kernels."""
    if exception is not None or app.builder.format != "html":
        return
    file = Path(app.outdir, PLACE)
    file.parent.mkdir(exist_ok=True)
    command = [sys.executable, "-m", "rss_gym", "page", "fly", "--out", str(file), "--overwrite"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ExtensionError(f"{PLACE} could not be made: {done.stderr.strip()}")


def setup(app: Sphinx) -> dict[str, bool]:
    """For Sphinx."""
    app.connect("build-finished", write, priority=100)  # before the links are checked
    return {"parallel_read_safe": True}
