"""Files that are no files, or too long, or TOML that takes memory, are refused at once and in one short sentence."""

import os
import resource
import subprocess
import sys
import time

import pytest

from rss_gym.baselines import AGENTS
from rss_gym.baselines.policy_files import document_of
from rss_gym.params import ParamsError, load_channel
from rss_gym.plain_files import read_json, read_plain, read_toml

PATIENCE_S = 900.0  # until something counts as hanging: the machine may be loaded
posix = pytest.mark.skipif(os.name != "posix", reason="devices of POSIX")


def no_files(tmp_path):
    """What may lie in a file's place."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    return [
        "/dev/zero",
        "/dev/null",
        "/dev/tty",
        *(tmp_path / name for name in ("pipe", "folder", "link", "loop", "no")),
    ]


@posix
def test_what_is_no_file_is_refused_at_once(tmp_path):
    for path in no_files(tmp_path):
        started = time.process_time()
        for read in (read_plain, read_toml, read_json):
            with pytest.raises((ParamsError, OSError)):
                read(path, 1000)
        assert time.process_time() - started < 1.0, path


@pytest.mark.slow
@posix
@pytest.mark.parametrize("command", ["eval", "verify", "leaderboard", "export", "train", "channel", "resume"])
def test_no_command_waits_for_a_pipe_or_fills_the_memory(tmp_path, command):
    agent = tmp_path / "agent"
    agent.mkdir()
    for name in ("policy.json", "policy.safetensors", "scores.json", "run.json", "recipe.toml"):
        os.mkfifo(agent / name)
    out = ["--out", str(tmp_path / "out")]
    given = {
        "eval": ["eval", "--policy", str(agent), "--episodes", "2", *out],
        "verify": ["verify", str(agent)],
        "leaderboard": ["leaderboard", str(agent), *out],
        "export": ["export", str(agent), *out],
        "train": ["train", str(agent / "recipe.toml"), *out],
        "channel": ["eval", "--policy", "none", "--channel", str(agent / "recipe.toml"), *out],
        "resume": ["train", "--resume", str(agent)],
    }[command]
    code = "import sys; from rss_gym.cli import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run([sys.executable, "-c", code, *given], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode in (1, 2) and "Traceback" not in done.stderr
    assert len(done.stdout + done.stderr) < 3000 and not (tmp_path / "out").exists()


def test_a_long_file_is_not_read_whole(tmp_path):
    path = tmp_path / "long"
    with open(path, "wb") as file:
        file.truncate(1 << 32)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ParamsError, match="larger than 1,000 bytes"):
        read_plain(path, 1000)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 10_000  # KiB
    path.write_bytes(b"x" * 1000)
    assert len(read_plain(path, 1000)) == 1000


DEEP = [
    ".".join("a" * 9) + " = 1",
    "[" + ".".join(["a"] * 9) + "]",
    "x = { " + " . ".join(['"a"'] * 20) + " = 1 }",
    "\n".join(".".join([f"k{n}"] * 300) + " = 1" for n in range(60)),
]


@pytest.mark.parametrize("text", DEEP, ids=range(len(DEEP)))
def test_deep_keys_are_refused(tmp_path, text):
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(ParamsError, match="more than 8 parts"):
        read_toml(tmp_path / "a.toml", 1 << 20)


@pytest.mark.parametrize("text", ["a" * 60_000, '"' * 60_000, "a." * 30_000, ("a" * 300 + "\n") * 200, "[" * 60_000])
def test_odd_text_takes_no_time(tmp_path, text):
    (tmp_path / "a.toml").write_text(text)
    started = time.process_time()
    with pytest.raises(ParamsError) as caught:
        read_toml(tmp_path / "a.toml", 1 << 20)
    assert time.process_time() - started < 2.0 and len(str(caught.value)) < 500


def test_numbers_and_sentences_are_no_keys(tmp_path):
    numbers = ", ".join(f"{n}.{n}" for n in range(50))
    text = f"# One. Two. Three. a.b.c e.g. this\nx = [{numbers}]\n[a.b.c.d]\n'e.f' = '1.2.3.4'\n"
    (tmp_path / "a.toml").write_text(text)
    assert read_toml(tmp_path / "a.toml", 10_000)["a"]["b"]["c"]["d"] == {"e.f": "1.2.3.4"}


def test_a_byte_order_mark_is_read_over(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbf[channel]\npath_loss_factor = 3.5\n")
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert load_channel(tmp_path / "a.toml").path_loss_factor == 3.5
    assert read_json(tmp_path / "a.json", 100) == {"a": 1}
    document = (AGENTS["ppo-plane"] / "policy.json").read_bytes()
    assert document_of(b"\xef\xbb\xbf" + document) == document_of(document)
