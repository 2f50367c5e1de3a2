"""The kernel decorator: where code is cached, and that callees are not stale."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from rss_gym import jit

REPOSITORY = Path(jit.__file__).resolve().parents[1]
RUN = "import tiny.a as a; print(a.outer(1.0), sum(a.outer.stats.cache_hits.values()))"


@pytest.fixture
def package(tmp_path):
    """A package in which a kernel calls a kernel of another file."""
    root = tmp_path / "tiny"
    root.mkdir()
    (root / "__init__.py").write_text("")
    (root / "a.py").write_text(
        "from rss_gym.jit import kernel\nfrom tiny.b import inner\n@kernel\ndef outer(x):\n    return inner(x) + 1.0\n"
    )
    _write_callee(root, "2.0")
    return root


def _write_callee(root, factor):
    (root / "b.py").write_text(
        f'from rss_gym.jit import kernel\n@kernel(inline="never")\ndef inner(x):\n    return {factor} * x\n'
    )


def _run(package):
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    environment["PYTHONPATH"] = os.pathsep.join([str(package.parent), str(REPOSITORY)])
    environment["XDG_CACHE_HOME"] = str(package.parent / "cache")
    environment["LOCALAPPDATA"] = environment["XDG_CACHE_HOME"]
    result = subprocess.run(
        [sys.executable, "-c", RUN],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    value, hits = result.stdout.split()
    return float(value), int(hits)


@pytest.mark.slow
def test_edited_callee_is_recompiled(package):
    assert _run(package) == (3.0, 0)
    assert _run(package) == (3.0, 1)
    _write_callee(package, "5.25")
    assert _run(package) == (6.25, 0)
    assert len(list((package.parent / "cache" / "tiny").iterdir())) == 2


def test_settings_of_numba_are_left_alone(package, monkeypatch):
    """Other users of Numba in the process do not notice."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "before")
    monkeypatch.syspath_prepend(str(package.parent))
    monkeypatch.setattr(jit.kernel_cache, "find", lambda tail: package.parent / "cache")
    jit.cache_dir.cache_clear()
    import tiny.a

    assert tiny.a.outer(1.0) == 3.0 and numba.config.CACHE_DIR == "before"
    jit.cache_dir.cache_clear()


def test_digest_follows_names_sources_and_links(package, tmp_path):
    digests = [jit._digest(package)]
    _write_callee(package, "3.0")
    digests.append(jit._digest(package))
    (package / "b.py").rename(package / "c.py")
    digests.append(jit._digest(package))
    linked = tmp_path / "elsewhere"
    linked.mkdir()
    (linked / "d.py").write_text("1")
    try:
        (package / "sub").symlink_to(linked, target_is_directory=True)
    except OSError:
        pytest.skip("no symbolic links here")
    digests.append(jit._digest(package))
    (linked / "d.py").write_text("2")
    digests.append(jit._digest(package))
    assert len(set(digests)) == 5
    (package / "notes.txt").write_text("not code")
    assert jit._digest(package) == digests[-1]


def test_parts_left_out_of_the_digest_hold_no_kernel():
    for (name,) in jit._WITHOUT_KERNELS:
        place = Path(jit.__file__).parent / name
        files = place.rglob("*.py") if place.is_dir() else [place]
        for file in files:
            text = file.read_text(encoding="utf-8")
            assert not re.search(r"rss_gym\.jit import .*\b(kernel|inner)\b", text), file
