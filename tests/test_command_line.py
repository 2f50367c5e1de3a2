"""The command line itself: what it says of itself, what it refuses, and what machines do to it."""

import argparse
import difflib
import errno
import os
import signal
import subprocess
import sys
import time

import pytest

import rss_gym
from rss_gym.cli import main, parser
from rss_gym.commands import COMMANDS, load

PATIENCE_S = 900.0  # until something counts as hanging: the machine may be loaded
posix = pytest.mark.skipif(os.name != "posix", reason="signals and streams of POSIX")


def run(capsys, *arguments):
    """Exit status, standard output and error."""
    try:
        status = main(list(arguments))
    except SystemExit as stop:
        status = stop.code or 0
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def started(*arguments, before="", code=None, **streams):
    """A process of the command line that is `list`, or of `code` in its place."""
    fake = "" if code is None else f"import rss_gym.commands.listing as m\ndef run(options):\n    {code}\nm.run = run\n"
    script = f"{before}\n{fake}import sys\nfrom rss_gym.cli import main\nsys.exit(main())"
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    return subprocess.Popen([sys.executable, "-c", script, *(arguments or ["list"])], text=True, **streams)


def one_sentence(text):
    return text.startswith("rss-gym: ") and text.count("\n") == 1


# -- what it says of itself -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_has_a_help_text(name):
    commands = next(a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    part = commands.choices[name]
    assert part.description
    for action in part._actions:
        assert action.help and len(action.help) > 10, f"{name} {action.option_strings or action.dest}"
        expanded = part._get_formatter()._expand_help(action)
        assert "%" not in expanded.replace(" % ", "") or "1 %" in expanded
    assert isinstance(load(name).HELP, str)


def test_alone_it_shows_its_commands(capsys):
    status, out, err = run(capsys)
    assert status == 0 and not err
    assert all(name in out for name in COMMANDS)
    assert run(capsys, "help") == (status, out, err) == run(capsys, "--help")


def test_version(capsys):
    assert run(capsys, "--version") == (0, f"rss-gym {rss_gym.__version__}\n", "")


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command(capsys, name):
    status, out, err = run(capsys, "help", name)
    assert status == 0 and not err and out.startswith(f"usage: rss-gym {name}")
    assert run(capsys, name, "--help") == (status, out, err)


def test_as_a_module():
    done = subprocess.run([sys.executable, "-m", "rss_gym", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"rss-gym {rss_gym.__version__}\n"


def slips(name):
    """Ways to mistype a name: a letter left out, doubled, or changed for its neighbour."""
    for at in range(1, len(name)):
        yield name[:at] + name[at + 1 :]
        yield name[:at] + name[at] + name[at:]
        yield name[: at - 1] + name[at] + name[at - 1] + name[at + 1 :]


def likeness(one, other):
    """Share of the letters that two words have in common, in order."""
    return difflib.SequenceMatcher(None, other, one).ratio()


@pytest.mark.parametrize("name", COMMANDS)
def test_a_mistyped_command_is_told_the_nearest(capsys, name):
    for number, wrong in enumerate(sorted({*slips(name)} - {*COMMANDS})):
        for arguments in ([wrong], ["help", wrong])[: 1 if number else 2]:
            status, out, err = run(capsys, *arguments)
            assert status == 2 and not out and one_sentence(err), wrong
            # Two commands may be as near: "eport" is "export" or "report".
            near = [one for one in COMMANDS if likeness(one, wrong) >= likeness(name, wrong)]
            assert any(f"did you mean '{one}'" in err for one in near), wrong


def test_a_mistyped_option_is_told_the_nearest(capsys):
    for wrong in {*slips("--episodes")} - {"--episodes", "--episode", "-episodes"}:
        status, out, err = run(capsys, "eval", "--policy", "none", "--out", "x", wrong, "3")
        assert status == 2 and not out and one_sentence(err), wrong
        assert "did you mean '--episodes'" in err or not wrong.startswith("--")


@pytest.mark.parametrize("wrong", ["--polcy", "--Policy", "--policies", "--agent"])
@pytest.mark.parametrize("joined", [False, True])
def test_a_mistyped_option_comes_before_the_one_that_is_missing(capsys, wrong, joined):
    given = [f"{wrong}=none"] if joined else [wrong, "none"]
    status, _, err = run(capsys, "eval", *given, "--out", "x")
    assert status == 2 and one_sentence(err) and repr(wrong) in err and "required" not in err


@pytest.mark.parametrize("count", ["1e99", "1e15", "9999999999999", "1e12"])
def test_more_episodes_than_any_machine_flies_are_refused(capsys, tmp_path, count):
    status, _, err = run(capsys, "eval", "--policy", "none", "--out", str(tmp_path / "x"), "--episodes", count)
    assert status == 2 and one_sentence(err) and "episodes" in err and "1,000,000,000" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("made", "words"),
    [
        ("missing", "no folder of that name"),
        ("empty", "a folder without policy.json"),
        ("link", "a link to nothing"),
        ("file", "a file"),
        ("missing/agent/", "no folder of that name"),
    ],
)
def test_a_path_that_holds_no_policy_says_what_it_is(capsys, tmp_path, made, words):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    (tmp_path / "link").symlink_to("gone")
    path = os.path.join(tmp_path, made)
    status, _, err = run(capsys, "eval", "--policy", path, "--out", str(tmp_path / "x"), "--episodes", "2")
    assert status == 2 and one_sentence(err) and path in err and words in err and "; known:" not in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["eval"], ["eval", "--policy", "--out"]),
        (["eval", "--policy", "none", "--out", "x", "--episodes", "ten"], ["--episodes", "'ten'", "10k"]),
        (["eval", "--policy", "none", "--out", "x", "--workers", "1.5"], ["--workers", "'1.5'"]),
        (["list", "everything"], ["list", "'everything'"]),
        (["--quiet"], ["COMMAND"]),
    ],
)
def test_wrong_arguments_are_one_sentence(capsys, arguments, words):
    status, out, err = run(capsys, *arguments)
    assert status == 2 and not out and one_sentence(err)
    assert all(word in err for word in words)


def test_a_very_long_name_does_not_fill_the_screen(capsys):
    status, _, err = run(capsys, "eval", "--policy", "x" * 900_000, "--out", "y")
    assert status == 2 and len(err) < 3000 and one_sentence(err)


# -- what machines do to it -------------------------------------------------------------------------------------------


@posix
def test_a_reader_that_goes_away_does_not_end_the_work(tmp_path):
    code = f"print('x' * 100_000, flush=True); print('y'); open({str(tmp_path / 'done')!r}, 'w').close()"
    process = started(code=code)
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1 and one_sentence(err) and "Broken pipe" in err
    assert (tmp_path / "done").exists()


@posix
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_output_that_is_full(tmp_path):
    with open("/dev/full", "w") as full:
        process = started(stdout=full)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1 and one_sentence(err) and "No space left" in err


@posix
@pytest.mark.parametrize("descriptors", ["1", "2", "1, 2"])
def test_streams_that_were_never_open(tmp_path, descriptors):
    process = started(before=f"import os\nfor d in [{descriptors}]: os.close(d)", code="print('x')")
    process.communicate(timeout=PATIENCE_S)
    assert process.returncode in (0, 1)


@pytest.mark.parametrize("encoding", ["cp1250", "ascii", "latin-1"])
def test_a_terminal_that_does_not_know_a_character(encoding):
    process = started(
        code="print('σ² ≤ 1 – fertig')", env={**os.environ, "PYTHONIOENCODING": encoding}, errors="replace"
    )
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and not err and "fertig" in out


@posix
def test_sigterm_ends_it_in_order(tmp_path):
    code = (
        "from rss_gym.files import reserved; import time\n"
        f"    with reserved({str(tmp_path / 'run')!r}): print('held', flush=True); time.sleep(3600)"
    )
    process = started(code=code)
    assert process.stdout.readline() == "held\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 143 and one_sentence(err) and "SIGTERM" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MemoryError(), ["not enough memory"]),
        (OSError(errno.ENOSPC, "No space left on device", "runs/x"), ["'runs/x'", "No space left", "free some"]),
        (OSError(errno.EROFS, "Read-only file system", "runs/x"), ["'runs/x'", "Read-only"]),
        (PermissionError(errno.EACCES, "Permission denied"), ["Permission denied"]),
        (OSError(errno.EMFILE, "Too many open files"), ["Too many open files"]),
        (OSError(errno.ENOSYS, "Function not implemented"), ["Function not implemented"]),
    ],
)
def test_errors_of_the_machine_are_one_sentence(capsys, monkeypatch, error, words):
    def fail(_):
        raise error

    monkeypatch.setattr(load("list"), "run", fail)
    status, out, err = run(capsys, "list")
    assert status == 1 and not out and one_sentence(err)
    assert all(word in err for word in words)


def test_an_error_of_the_program_keeps_its_traceback(monkeypatch):
    def fail(_):
        raise AssertionError

    monkeypatch.setattr(load("list"), "run", fail)
    with pytest.raises(AssertionError):
        main(["list"])
    assert sys.stdout is not None and not hasattr(sys.stdout, "error")  # the streams are as before


def test_uncompiled_kernels_are_refused(tmp_path):
    given = ["eval", "--policy", "none", "--episodes", "1", "--out", str(tmp_path / "run")]
    process = started(*given, env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2 and not out and one_sentence(err) and "NUMBA_DISABLE_JIT" in err
    assert not list(tmp_path.iterdir())


@posix
def test_what_was_flown_is_kept_where_the_disk_is_full(tmp_path):
    """The file system of the folder is full, the one for temporary files is not."""
    full = (
        "import rss_gym.files as f, os\n"
        "whole = f.write_bytes\n"
        "def write(path, content):\n"
        "    if str(path).startswith(os.environ['FULL']): raise OSError(28, 'No space left on device', str(path))\n"
        "    return whole(path, content)\n"
        "f.write_bytes = write"
    )
    given = ["eval", "--policy", "none", "--episodes", "3", "--out", str(tmp_path / "full" / "run")]
    (tmp_path / "full").mkdir()
    (tmp_path / "temporary").mkdir()
    places = {"FULL": str(tmp_path / "full"), "TMPDIR": str(tmp_path / "temporary")}
    process = started(*given, before=full, env={**os.environ, **places})
    out, err = process.communicate(timeout=PATIENCE_S)
    sentence = [line for line in err.splitlines() if line.startswith("rss-gym: ")]
    assert process.returncode == 2 and not out and len(sentence) == 1 and "Traceback" not in err
    assert "No space left on device" in sentence[0] and "the results are in" in sentence[0]
    (kept,) = (tmp_path / "temporary").glob("rss-gym-*/results")
    assert str(kept) in sentence[0] and {"scores.json", "tables", "report.html"} <= set(os.listdir(kept))
    assert not list((tmp_path / "full").iterdir())
