"""rl_zoo3: train and enjoy."""

import subprocess
import sys
import tempfile
from pathlib import Path

ID = "rss_gym/Encounter-v0"
CONFIG = f"""
{ID}:
  n_timesteps: !!float 1000
  policy: 'MlpPolicy'
  n_envs: 2
  n_steps: 64
  batch_size: 64
"""

if __name__ == "__main__":
    folder = Path(tempfile.mkdtemp())
    (folder / "ppo.yml").write_text(CONFIG)
    common = ["--algo", "ppo", "--env", ID, "--gym-packages", "rss_gym", "--folder", str(folder / "logs")]
    train = [sys.executable, "-m", "rl_zoo3.train", *common, "--conf-file", str(folder / "ppo.yml"), "--device", "cpu"]
    train[train.index("--folder")] = "--log-folder"
    subprocess.run([*train, "--eval-freq", "500", "--eval-episodes", "1", "-P"], check=True, cwd=folder)
    enjoy = [sys.executable, "-m", "rl_zoo3.enjoy", *common, "--no-render", "-n", "300", "--device", "cpu"]
    subprocess.run(enjoy, check=True, cwd=folder)
    print("* train and enjoy")
