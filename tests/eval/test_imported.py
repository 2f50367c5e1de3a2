"""Policies given as code, in every shape in which people write one."""

import sys

import numpy as np
import pytest

from rss_gym.eval.imported import imported
from rss_gym.params import Params, ParamsError

SOURCE = """
import numpy as np
from beside import RIGHT

class Plain:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 2), RIGHT, np.float32), state

class Keeps(Plain):
    def __init__(self, params):
        self.given = params

class Named(Plain):
    def __init__(self, gain=2.0, world=None):
        self.gain, self.given = gain, world

class World(Plain):
    def __init__(self, world=None):
        self.given = world

class Options(Plain):
    def __init__(self, gain=2.0):
        self.gain = gain

class Anything(Plain):
    def __init__(self, *arguments, **keywords):
        self.arguments = arguments

class Outer:
    class Inner(Plain):
        pass

    @staticmethod
    def make():
        return Plain()

class Two(Plain):
    def __init__(self, one, two): ...

class Broken(Plain):
    def __init__(self): raise RuntimeError("no such thing")

def made(params): return Keeps(params)
def plain(): return Plain()
ready = Plain()
number = 3
"""
KINDS = "Plain Keeps Named World Options Anything Outer.Inner Outer.make made plain ready".split()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "beside.py").write_text("RIGHT = 0.5\n")
    (tmp_path / "mine.py").write_text(SOURCE)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    yield tmp_path
    for name in ("mine", "beside", *(name for name in sys.modules if name.startswith("policy_mine"))):
        sys.modules.pop(name, None)


@pytest.mark.parametrize("how", ["module", "file", "relative"])
@pytest.mark.parametrize("kind", KINDS)
def test_every_shape_flies(folder, monkeypatch, kind, how):
    monkeypatch.chdir(folder)
    where = {"module": "mine", "file": str(folder / "mine.py"), "relative": "./mine.py"}[how]
    policy = imported(f"{where}:{kind}", Params())
    actions, _ = policy.predict(np.zeros((3, 5), np.float32))
    assert (actions == 0.5).all()
    if kind in ("Keeps", "World", "made"):
        assert policy.given == Params()
    if kind in ("Named", "Options"):
        assert policy.gain == 2.0


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("Two", "failed to be made"),
        ("Broken", "no such thing"),
        ("number", "predict"),
        ("Missing", "Missing"),
        ("Outer.Missing", "Missing"),
        ("", "neither"),
    ],
)
def test_what_is_no_policy_is_named(folder, kind, words):
    for where in ("mine", str(folder / "mine.py")):
        with pytest.raises(ParamsError, match=words) as caught:
            imported(f"{where}:{kind}", Params())
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("where", ["nowhere", "nowhere.py", "/dev/null/a.py", ".py", ""])
def test_what_is_not_there_is_named(folder, where):
    with pytest.raises(ParamsError, match="neither a known name"):
        imported(f"{where}:Plain", Params())
