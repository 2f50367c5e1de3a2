"""Settings for all tests."""

import os

from hypothesis import settings

# Windows of pygame and figures of matplotlib go nowhere; both read these before they are imported.
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")

# The first example may compile a kernel, so there is no deadline; in CI every run draws the same examples.
settings.register_profile("dev", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "dev")
