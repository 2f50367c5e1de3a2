"""The cache of compiled kernels: whatever is the matter with its folder, programs run, and say once what it is."""

import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rss_gym import jit, kernel_cache

pytestmark = pytest.mark.slow

PATIENCE_S = 900.0  # until something counts as hanging: the machine may be loaded
REPOSITORY = Path(jit.__file__).resolve().parents[1]
RUN = """
import sys, time
import tiny.a as a
print(a.outer(1.0), sum(a.outer.stats.cache_hits.values()), sum(a.outer.stats.cache_misses.values()))
"""


@pytest.fixture
def package(tmp_path):
    """A package of one kernel."""
    root = tmp_path / "packages" / "tiny"
    root.mkdir(parents=True)
    (root / "__init__.py").write_text("")
    (root / "a.py").write_text("from rss_gym.jit import kernel\n@kernel\ndef outer(x):\n    return 2.0 * x + 1.0\n")
    return root


def environment(package, cache, **more):
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("NUMBA_", "XDG_", "HOME"))}
    places = {"XDG_CACHE_HOME": str(cache), "LOCALAPPDATA": str(cache), "HOME": str(cache)}
    path = os.pathsep.join([str(package.parent), str(REPOSITORY)])
    return kept | places | {"PYTHONPATH": path, "TMPDIR": str(package.parent.parent)} | more


def run(package, cache, before="", **more):
    """Value, hits and misses of a new process, and what it said."""
    given = environment(package, cache, **more)
    given = {name: value for name, value in given.items() if value is not None}
    done = subprocess.run([sys.executable, "-c", before + RUN], env=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    value, hits, misses = done.stdout.split()
    return float(value), int(hits), int(misses), done.stderr


def files(cache):
    return sorted(path for path in Path(cache).rglob("*.nb[ic]"))


def test_it_is_kept_and_read(package, tmp_path):
    cache = tmp_path / "cache"
    assert run(package, cache) == (3.0, 0, 1, "")
    assert run(package, cache) == (3.0, 1, 0, "")
    assert len(files(cache)) == 2
    for folder in (cache / "tiny", *(cache / "tiny").iterdir()):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_new_checkout_with_the_same_sources_compiles_nothing(package, tmp_path):
    cache = tmp_path / "cache"
    run(package, cache)
    other = tmp_path / "elsewhere" / "tiny"
    other.parent.mkdir()
    package.rename(other)
    for file in other.glob("*.py"):
        os.utime(file, (0, 0))
    assert run(other, cache) == (3.0, 1, 0, "")


DAMAGES = {
    "empty": lambda data: b"",
    "cut": lambda data: data[: len(data) // 2],
    "a flipped bit": lambda data: data[:-9] + bytes([data[-9] ^ 4]) + data[-8:],
    "something else": lambda data: b"not a cache",
}


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_compiled_anew(package, tmp_path, kind, damage):
    cache = tmp_path / "cache"
    run(package, cache)
    (path,) = Path(cache).rglob(f"*.{kind}")
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    value, _, misses, said = run(package, cache)
    assert (value, misses) == (3.0, 1)
    assert said.count("\n") == 1 and "is damaged" in said
    assert run(package, cache) == (3.0, 1, 0, "")  # and it is whole again


@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
def test_a_full_disk_keeps_nothing_and_says_so_once(package, tmp_path):
    cache = tmp_path / "cache"
    full = (
        "import resource, signal\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"
    )
    value, _, misses, said = run(package, cache, full)
    assert (value, misses) == (3.0, 1)
    assert said.count("\n") == 1 and "cannot be kept" in said
    assert not files(cache) and not list(Path(cache).rglob("*.tmp.*"))


def test_a_folder_that_cannot_be_made(package, tmp_path):
    (tmp_path / "file").write_text("")
    value, _, misses, said = run(package, tmp_path / "file")
    assert (value, misses, said) == (3.0, 1, "")  # the temporary folder takes its place
    assert len(files(tmp_path)) == 2
    value, _, misses, said = run(package, tmp_path / "file", "import tempfile; tempfile.tempdir = '/dev/null'\n")
    assert (value, misses) == (3.0, 1)
    assert said.count("\n") == 1 and "no folder" in said


def test_without_a_home_no_folder_named_tilde(package, tmp_path):
    place = tmp_path / "here"
    place.mkdir()
    for home in (None, "", "relative"):
        gone = "import os, pwd; pwd.getpwuid = lambda _: {}['no such user']\n" if home is None else ""
        run(package, None, f"import os; os.chdir({str(place)!r})\n" + gone, XDG_CACHE_HOME=None, HOME=home)
    assert list(place.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("what", ["folder", "file"])
def test_what_another_user_owns_is_not_unpickled(package, tmp_path, what):
    cache = tmp_path / "cache"
    run(package, cache)
    marked = tmp_path / "was-unpickled"
    for path in files(cache):
        evil = b"cos\nsystem\n(S'touch " + str(marked).encode() + b"'\ntR."
        import hashlib

        path.write_bytes(hashlib.sha256(evil).digest() + evil)
        if what == "file":
            os.chown(path, 12345, 12345)
    if what == "folder":
        os.chown(cache / "tiny", 12345, 12345)
    value, _, misses, said = run(package, cache)
    assert (value, misses) == (3.0, 1) and not marked.exists()
    assert said.count("\n") <= 1


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
def test_a_folder_that_everybody_can_write_is_not_used(package, tmp_path):
    cache = tmp_path / "cache"
    run(package, cache)
    (cache / "tiny").chmod(0o777)
    assert run(package, cache)[1:3] == (0, 1)


@pytest.mark.skipif(not hasattr(os, "symlink"), reason="no symbolic links here")
def test_a_link_in_the_temporary_folder_is_not_followed(package, tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(tmp_path / "temp"))
    (tmp_path / "temp").mkdir()
    (tmp_path / "mine").mkdir()
    (tmp_path / "temp" / "cache-0").symlink_to(tmp_path / "mine")
    with pytest.raises(OSError, match="is not a folder"):
        kernel_cache._prepared(tmp_path / "temp" / "cache-0", Path("tiny"))


def test_a_full_read_only_folder_is_read(package, tmp_path):
    """As in the image of a container."""
    cache = tmp_path / "cache"
    run(package, cache)
    for path in sorted(cache.rglob("*"), reverse=True):
        path.chmod(0o500 if path.is_dir() else 0o400)
    assert run(package, cache) == (3.0, 1, 0, "")


def test_cold_processes_compile_once(package, tmp_path):
    """Each of them is held until all have missed the cache."""
    cache, count = tmp_path / "cache", 4
    (tmp_path / "ready").mkdir()
    together = (
        "import os, pathlib, time\n"
        f"ready = pathlib.Path({str(tmp_path / 'ready')!r})\n"
        "import tiny.a\n"
        "(ready / str(os.getpid())).touch()\n"
        f"while len(list(ready.iterdir())) < {count}: time.sleep(0.01)\n"
    )
    started = [
        subprocess.Popen(
            [sys.executable, "-c", together + RUN],
            env=environment(package, cache),
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(count)
    ]
    results = [process.communicate(timeout=PATIENCE_S)[0].split() for process in started]
    assert [value for value, *_ in results] == ["3.0"] * count
    assert sum(int(misses) for *_, misses in results) == 1
    assert sum(int(hits) for _, hits, _ in results) == count - 1


def test_a_failed_compilation_gives_the_turn_back(package, tmp_path):
    folder = tmp_path / "cache"
    folder.mkdir()
    turn = kernel_cache.Turn(folder)
    with pytest.raises(RuntimeError), turn.scope():
        assert turn.take() and not turn.take()
        raise RuntimeError
    with turn.scope(), kernel_cache.Turn(folder).scope():
        assert turn.take()


def test_a_file_system_without_locks_does_not_matter(tmp_path, monkeypatch):
    def unable(_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(kernel_cache, "take", unable)
    turn = kernel_cache.Turn(tmp_path)
    with turn.scope():
        started = time.monotonic()
        assert not turn.take() and time.monotonic() - started < kernel_cache.WAIT_S / 2.0
