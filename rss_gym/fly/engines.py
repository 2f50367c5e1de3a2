"""What can run JavaScript on this machine, for comparisons and tests."""

from __future__ import annotations

import html
import shutil
import subprocess
import tempfile
from pathlib import Path

NAMES = {"node": ("node", "nodejs"), "chromium": ("chromium", "chromium-browser", "google-chrome")}
TIMEOUT_S = 600


def engines() -> dict[str, str]:
    """Name -> path of each engine that is here."""
    found = {name: next(filter(None, map(shutil.which, commands)), None) for name, commands in NAMES.items()}
    return {name: path for name, path in found.items() if path}


def result_of(code: str, engine: str) -> str:
    """The text that a script leaves in the constant `result`.

    Parameters
    ----------
    code : str
        A script.
    engine : str
        One of `engines()`.

    Raises
    ------
    RuntimeError
        With what the engine says, if the script fails.
    """
    if engine != "node":
        page = f'<!doctype html><meta charset="utf-8"><pre id="out"></pre><script>{code}\n'
        page += 'document.getElementById("out").textContent = "=" + result;</script>'
        shown = rendered(page).partition('<pre id="out">=')[2]
        if not shown:
            raise RuntimeError("the script failed in Chromium")
        return html.unescape(shown.partition("</pre>")[0])
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder, "run.js")
        script.write_text(code + "\nprocess.stdout.write(result);\n", encoding="utf-8")
        return _output([engines()[engine], str(script)])


def rendered(page: str, fragment: str = "") -> str:
    """A page as Chromium holds it once its scripts have run, as HTML.

    Parameters
    ----------
    page : str
        The page, HTML.
    fragment : str
        What follows `#` in its address.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "page.html")
        file.write_text(page, encoding="utf-8")
        options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile"]
        options += [f"--timeout={1000 * TIMEOUT_S}", "--dump-dom", f"{file.as_uri()}#{fragment}"]
        return _output([engines()["chromium"], *options])


def _output(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    if done.returncode:
        raise RuntimeError(f"{Path(command[0]).name} failed: {done.stderr.strip()[-2000:]}")
    return done.stdout
