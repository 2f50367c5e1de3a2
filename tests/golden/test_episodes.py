"""Whole episodes equal the frozen ones: here, without the host's vector units, and compiled for other CPUs."""

import importlib.util
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest
from numpy._core import _multiarray_umath as core

MAKE = Path(__file__).with_name("make.py")
CHANGED = "The world's numbers have changed; if that was meant, run: python tests/golden/make.py"


def _module():
    spec = importlib.util.spec_from_file_location("golden_make", MAKE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


make = _module()
FROZEN = json.loads(make.FILE.read_text(encoding="utf-8"))


def in_a_new_process(**variables):
    """The digests under other environment variables."""
    result = subprocess.run(
        [sys.executable, str(MAKE), "--print"],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def changed(digests):
    """Names of the cases that are not as frozen."""
    return [case for case in FROZEN if digests.get(case) != FROZEN[case]]


def test_every_case_is_frozen():
    assert list(FROZEN) == list(make.CASES), CHANGED


@pytest.mark.parametrize("case", make.CASES)
def test_episodes(case):
    assert make.fly(case) == FROZEN[case], CHANGED


def test_cases_differ():
    """Each option reaches the numbers, and the flights contain both ends."""
    assert len({case["sha256"] for case in FROZEN.values()}) == len(FROZEN)
    assert {True, False} == {collision for case in FROZEN.values() for collision in case["collisions"]}


@pytest.mark.slow
def test_without_vector_units():
    """NumPy's dispatched loops off: none of them reaches a trajectory."""
    features = [name for name in core.__cpu_dispatch__ if core.__cpu_features__[name]]
    if not features:
        pytest.skip("this host has nothing to disable")
    code = "from numpy._core._multiarray_umath import __cpu_features__ as f; print(*[n for n in f if f[n]])"
    off = {"NPY_DISABLE_CPU_FEATURES": " ".join(features)}
    left = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **off}, capture_output=True, text=True, check=True
    )
    assert not set(features) & set(left.stdout.split())
    assert changed(in_a_new_process(**off)) == []


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names of x86 CPUs")
@pytest.mark.parametrize("cpu", ["generic", "haswell"])
def test_compiled_for_another_cpu(cpu):
    """`generic` has neither AVX nor fused multiply-add, `haswell` has both: LLVM may use what it likes.

    The empty list of features keeps Numba from adding this host's own.
    """
    if cpu == "haswell" and not core.__cpu_features__.get("FMA3", core.__cpu_features__.get("X86_V3")):
        pytest.skip("this host cannot run code for haswell")
    assert changed(in_a_new_process(NUMBA_CPU_NAME=cpu, NUMBA_CPU_FEATURES="")) == []
