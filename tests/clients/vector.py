"""Gymnasium: its checker, this package's tests of the vector interface, and its own tests where a checkout is given."""

import os
import re
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
from gymnasium.utils.env_checker import check_env

import rss_gym  # noqa: F401
from rss_gym.ids import IDS

ROOT = Path(__file__).resolve().parents[2]
TESTS = "tests/contracts/test_vector_interface.py"


def pytest(*arguments, cwd=ROOT, **environment):
    """Run it in a process of its own; the closing line, without the time."""
    command = [sys.executable, "-m", "pytest", "-o", "addopts=", "-q", "-p", "no:cacheprovider", *arguments]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, env=os.environ | environment, check=False)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    return re.sub(r" in [\d.]+s.*", "", done.stdout.strip().splitlines()[-1])


def refused_before_1_0():
    """Whether `make_vec` in mode `custom`, which drops the keywords of an id, is refused."""
    try:
        gym.make_vec("rss_gym/Encounter3D-v0", num_envs=2, vectorization_mode="custom")
    except gym.error.Error:
        return True
    return False


if __name__ == "__main__":
    for name in IDS:
        check_env(gym.make(name).unwrapped, skip_render_check=True)
        assert gym.make(gym.make(name).spec).reset(seed=1)[0].shape == gym.make(name).observation_space.shape
        made = gym.make_vec(name, num_envs=2, vectorization_mode="sync")
        assert made.reset(seed=0)[0].shape[0] == 2
    print("* every id checked")
    if gym.__version__.startswith("0."):
        assert refused_before_1_0()
        print("* make_vec in mode `custom` refused, as it would drop the keywords of an id")
    print(f"* tests of the vector interface: {pytest(TESTS)}")
    checkout = Path(os.environ.get("CLIENT_CHECKOUTS", "none")) / "gymnasium"
    if checkout.exists() and hasattr(gym.vector, "AutoresetMode"):
        from gymnasium_vector import SELECTED

        said = pytest("-p", "gymnasium_vector", *SELECTED, cwd=checkout, PYTHONPATH=os.pathsep.join(sys.path[:2]))
        print(f"* Gymnasium's own vector tests on ours: {said}")
