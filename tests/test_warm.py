"""`rss-gym warm` compiles whatever other commands call."""

import subprocess
import sys
from pathlib import Path

import pytest

from rss_gym import jit
from rss_gym.cli import main

ROOT = Path(jit.__file__).parent.resolve()


def compiled():
    return {path.name for path in Path(jit.cache_dir(ROOT)).rglob("*.nb[ic]")}


def in_a_new_process(*arguments):
    """What is compiled on disk after a command that ran in a process of its own."""
    code = "import sys; from rss_gym.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return compiled()


@pytest.mark.slow
def test_after_it_nothing_is_compiled_any_more(tmp_path, capsys):
    if jit.cache_dir(ROOT) is None:
        pytest.skip("nothing can be kept here")
    assert main(["warm"]) == 0
    assert str(jit.cache_dir(ROOT)) in capsys.readouterr().out
    before = compiled()
    assert len(before) > 100
    levels = ["--information", "positions", "ranges", "oracle"]
    fly = ["eval", "--policy", "all", *levels, "--episodes", "3", "--out"]
    assert in_a_new_process(*fly, tmp_path / "a") == before
    assert in_a_new_process(*fly[:3], "--suite", "encounter3d-v0", *fly[7:], tmp_path / "b") == before
    assert in_a_new_process("list", "--json") == before
    (tmp_path / "log.py").write_text(
        "import sys, numpy as np\n"
        "from rss_gym.radio import simulate\n"
        "log = simulate(np.linspace(80.0, 5.0, 3000), 0.1, 'outdoor', seed=int(sys.argv[1]))\n"
        "rows = zip(log.time_s, log.rss_dbm, log.distance_m)\n"
        "print('time_s,rss_dbm,distance_m', *(f'{t},{r},{d}' for t, r, d in rows), sep='\\n')\n"
    )
    done = subprocess.run([sys.executable, tmp_path / "log.py", "1"], capture_output=True, text=True, check=True)
    (tmp_path / "log.csv").write_text(done.stdout)
    assert in_a_new_process("calibrate", tmp_path / "log.csv", "--out", tmp_path / "channel.toml") == before
