"""Run other libraries against this package, each in an environment of its own, and write what came out as a table.

`make clients`, or `python tests/clients/run.py NAME ...` for some of them. Not part of the tests: the environments take
gigabytes. They are made by uv, which is installed into one of its own: pip searches for a quarter of an hour where many
packages hang together. Folders of wheels that PIP_FIND_LINKS names are used too.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import venv
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "clients.md"
SCRIPTS = "Scripts" if os.name == "nt" else "bin"
OWN = ("jinja2", "numba", "safetensors", "scipy", "tqdm")  # what this package needs beside Gymnasium and NumPy
BEGIN, END = "<!-- clients -->\n", "<!-- /clients -->"


@dataclass(frozen=True)
class Client:
    """A library and the script that uses it as its documentation does.

    Parameters
    ----------
    script : str
        In this folder.
    packages : tuple of str
        To install.
    shown : tuple of str
        Distributions whose versions the table names.
    alone : tuple of str
        Packages to install without what they ask for.
    """

    script: str
    packages: tuple[str, ...]
    shown: tuple[str, ...]
    alone: tuple[str, ...] = ()


TESTS = ("hypothesis", "pillow", "pytest")  # of behaviour, run by pytest
CLIENTS = {
    "gymnasium, oldest": Client("vector.py", ("gymnasium==0.29.1", *TESTS), ("gymnasium", "numpy")),
    "gymnasium 1.0": Client("vector.py", ("gymnasium==1.0.0", *TESTS), ("gymnasium", "numpy")),
    "gymnasium, newest": Client("vector.py", ("gymnasium", *TESTS), ("gymnasium", "numpy")),
    "sb3": Client(
        "sb3.py",
        ("stable-baselines3", "sb3-contrib", "torch", "pandas"),
        ("stable-baselines3", "sb3-contrib", "gymnasium"),
    ),
    "rl_zoo3": Client("zoo.py", ("rl_zoo3", "requests", "torch"), ("rl-zoo3", "stable-baselines3", "gymnasium")),
    "cleanrl": Client(
        "cleanrl.py",
        ("gymnasium==0.29.1", "tensorboard", "torch", "tyro"),
        ("cleanrl", "gymnasium", "torch"),
        alone=("cleanrl==1.2.0",),  # it pins a Python, a pygame and a gym that no new system has
    ),
    "imitation": Client("imitate.py", ("imitation==1.0.1", "torch"), ("imitation", "stable-baselines3", "gymnasium")),
    "d3rlpy": Client("d3rl.py", ("d3rlpy==2.8.1", "torch"), ("d3rlpy", "gymnasium")),
    "torchrl": Client("torch_rl.py", ("torchrl", "gymnasium", "torch"), ("torchrl", "tensordict", "gymnasium")),
    "minari": Client("minari_set.py", ("minari[hdf5,create]", "pillow"), ("minari", "gymnasium")),
    "tianshou": Client("tianshou_sac.py", ("tianshou[eval]", "torch"), ("tianshou", "gymnasium")),
    "skrl": Client("skrl_ppo.py", ("skrl", "gymnasium", "torch"), ("skrl", "gymnasium")),
    "rllib": Client("rllib_ppo.py", ("ray[rllib]", "torch"), ("ray", "gymnasium")),
}


def main() -> int:
    """Run the clients that are named, or all; 1 if any failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *CLIENTS], help="clients (default: all)")
    parser.add_argument("--folder", type=Path, default=ROOT / ".clients", help="where the environments are made")
    parser.add_argument("--install-s", type=float, default=900.0, help="time for one installation")
    parser.add_argument("--run-s", type=float, default=600.0, help="time for one script")
    options = parser.parse_args()
    installer = _Installer(options.folder, options.install_s)
    rows = _table()
    failed = False
    for name in options.names or CLIENTS:
        print(f"== {name}", flush=True)
        versions, outcome, right = _ran(CLIENTS[name], installer, re.sub(r"\W+", "-", name), options.run_s)
        failed |= not right
        rows[name] = f"| {name} | {versions} | {outcome} |"
        _write(rows)
        print(f"{versions}: {outcome}", flush=True)
    return int(failed)


class _Installer:
    """Makes environments in a folder, with the version of PyTorch that the tests of this package run with."""

    def __init__(self, folder: Path, limit_s: float):
        self.folder, self.limit_s = folder, limit_s
        self.torch = folder / "torch.txt"
        self.uv = [folder / "uv" / SCRIPTS / "uv", "pip", "install", "--quiet", "--constraint", self.torch]
        for links in os.environ.get("PIP_FIND_LINKS", "").split():
            self.uv += ["--find-links", links]

    def python(self, name: str, client: Client) -> Path:
        """The interpreter of an environment that holds the client's packages; it is made unless it is there."""
        python = self.folder / name / SCRIPTS / "python"
        if not python.exists():
            if not self.uv[0].exists():
                venv.create(self.folder / "uv", with_pip=True)
                pip = [self.folder / "uv" / SCRIPTS / "python", "-m", "pip", "install", "--quiet", "uv"]
                subprocess.run(pip, check=True, timeout=self.limit_s)
            pins = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if line.startswith("torch==")]
            self.torch.write_text("\n".join(pins))
            venv.create(self.folder / name)
            try:
                for packages in (*client.packages, *OWN), ("--no-deps", *client.alone):
                    if packages[1:]:
                        command = [*self.uv, "--python", python, *packages]
                        subprocess.run(command, check=True, timeout=self.limit_s)
            except BaseException:
                shutil.rmtree(self.folder / name)
                raise
        return python


def _ran(client: Client, installer: _Installer, name: str, run_s: float) -> tuple[str, str, bool]:
    """Versions, outcome, and whether the script ran to its end."""
    try:
        started = time.monotonic()
        python = installer.python(name, client)
        print(f"installed in {time.monotonic() - started:.0f} s", flush=True)
        code = "import sys; from importlib.metadata import version as v; print(*map(v, sys.argv[1:]))"
        found = subprocess.run([python, "-c", code, *client.shown], capture_output=True, text=True, check=True)
        versions = ", ".join(" ".join(pair) for pair in zip(client.shown, found.stdout.split(), strict=True))
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        return ", ".join(client.shown), f"not run: {type(error).__name__} at the installation", False
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    started = time.monotonic()
    try:
        done = subprocess.run(
            [python, Path(__file__).with_name(client.script)],
            capture_output=True, text=True, errors="replace", timeout=run_s, env=environment, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return versions, f"FAILED: not done after {run_s:.0f} s", False
    lines = [line.strip() for line in done.stdout.splitlines() if line.strip()] or [""]
    said = [line[2:] for line in lines if line.startswith("* ")]
    if done.returncode:
        last = ([line for line in done.stderr.splitlines() if line.strip()] or lines)[-1]
        return versions, f"FAILED: {_cell(last)}", False
    print(f"ran in {time.monotonic() - started:.0f} s")
    return versions, _cell("; ".join(said)), True


def _cell(text: str) -> str:
    """Text for one cell of a table, without colours."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text).replace("|", "/")[:300]


def _table() -> dict[str, str]:
    """The rows of the page, by client."""
    text = PAGE.read_text(encoding="utf-8")
    rows = text[text.index(BEGIN) + len(BEGIN) : text.index(END)].splitlines()[2:]
    return {row.split("|")[1].strip(): row for row in rows}


def _write(rows: dict[str, str]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    kept = [rows[name] for name in CLIENTS if name in rows]
    table = "\n".join(["| client | versions | what ran |", "| --- | --- | --- |", *kept, ""])
    before, after = text[: text.index(BEGIN) + len(BEGIN)], text[text.index(END) :]
    PAGE.write_text(before + table + after, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
