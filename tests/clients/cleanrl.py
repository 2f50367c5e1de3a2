"""CleanRL's `ppo_continuous_action.py` as it is published, unmodified, on the id in the form `module:id`.

The script is that of the installed distribution, and with a checkout in `CLIENT_CHECKOUTS/cleanrl` the newest one as
well.
"""

import os
import re
import subprocess
import sys
import tempfile
from importlib.metadata import distribution
from pathlib import Path

NAME = "cleanrl/ppo_continuous_action.py"
STEPS = ["--total-timesteps", "2000", "--num-envs", "4", "--num-steps", "128", "--num-minibatches", "4"]


def run(script, origin):
    """Run a script by its file name, in a folder of its own, for three updates."""
    command = [sys.executable, script, "--env-id", "rss_gym:rss_gym/Encounter-v0", *STEPS]
    done = subprocess.run(command, cwd=tempfile.mkdtemp(), capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    returns = re.findall(r"episodic_return=\[?(-?[\d.]+)", done.stdout)
    assert len(returns) > 3, done.stdout
    print(f"* {Path(script).name} {origin}, unmodified: {len(returns)} episodes in three updates")


if __name__ == "__main__":
    published = distribution("cleanrl")
    run(published.locate_file(NAME), f"of cleanrl {published.version}")
    checkout = Path(os.environ.get("CLIENT_CHECKOUTS", "none")) / "cleanrl" / NAME
    if checkout.exists():
        run(checkout, "of its repository")
