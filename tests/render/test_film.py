"""Films of flights: the same encounter for each policy, files that are what they say, and errors in one sentence."""

import sys

import gymnasium as gym
import numpy as np
import pytest

import rss_gym
from rss_gym import baselines, cli
from rss_gym.params import ParamsError
from rss_gym.render import film

pytest.importorskip("PIL")
from PIL import Image

assert rss_gym.__version__
SHORT = ["--seed", "9", "--width", "400", "--set", "tail_min_s=15", "tail_max_s=16"]


@pytest.fixture(scope="module")
def flights():
    env = gym.make("rss_gym/Encounter-v0", disable_env_checker=True)
    return [film.fly(env, baselines.make(name), name, 9) for name in ("none", "orca")]


def test_all_fly_the_same_encounter(flights):
    one, other = (flight.scenes[0] for flight in flights)
    assert np.array_equal(one.intruders[0].position_m, other.intruders[0].position_m)
    assert flights[0].collision and flights[0].outcome.endswith("m, collision") and not flights[1].collision
    index = film.nearest(flights[1])
    gaps = [np.linalg.norm(s.intruders[0].position_m - s.own.position_m) for s in flights[1].scenes]
    assert gaps[index] == min(gaps)


def test_a_frame_has_a_picture_for_each_and_one_that_is_over_stays_at_its_end(flights):
    last = len(flights[0].scenes) - 1  # ends first, with a collision
    assert last < len(flights[1].scenes) - 1
    frame, later = film.beside(flights, last, 401), film.beside(flights, last + 5, 401)
    assert frame.shape == (334, 800, 3) and frame.dtype == np.uint8
    assert np.array_equal(frame[:, :400], later[:, :400]) and not np.array_equal(frame[:, 400:], later[:, 400:])
    with pytest.raises(ParamsError, match="--width 300 is too small"):
        film.beside(flights, 0, 300)


def test_an_animation_has_every_frame_and_is_as_fast_as_the_flight(flights, tmp_path):
    file = film.save(flights[:1], str(tmp_path / "a.gif"), 400, every=10)
    with Image.open(file) as image:
        assert image.n_frames == len({*range(0, len(flights[0].scenes) - 1, 10)}) + 1
        assert image.info["duration"] == 1000 and image.size == (400, 334)


def test_a_video_is_one(flights, tmp_path):
    pytest.importorskip("moviepy")
    assert film.save(flights[:1], str(tmp_path / "a.mp4"), 400, every=20).read_bytes()[4:8] == b"ftyp"
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_record_writes_a_picture_once(tmp_path, capsys):
    file = tmp_path / "a.png"
    command = ["record", "--policy", "orca", "none", *SHORT, "--out", str(file)]
    assert cli.main(command) == 0
    out = capsys.readouterr().out
    assert out.startswith("orca: cost ") and "none: cost 10,10" in out and file.read_bytes().startswith(b"\x89PNG")
    assert cli.main(command) == 2 and "exists already" in capsys.readouterr().err
    assert cli.main([*command, "--overwrite"]) == 0


@pytest.mark.parametrize(
    "arguments", [["record", "--policy", "none", "--out", "a.gif"], ["watch", "--policy", "none"]], ids=lambda a: a[0]
)
def test_a_missing_package_is_named_before_anything_flies(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(film, "find_spec", lambda name: None)
    monkeypatch.setattr(film, "fly", None)
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert not out and "needs Pillow: pip install -e '.[render]' in the clone" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--out", "a.jpg"], "must end with .mp4, .gif, .png"),
        (["--out", "a.png", "--set", "intruder=2"], "intruder"),
        (["--out", "a.png", "--width", "100"], "at least 400"),
    ],
)
def test_record_refuses(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["record", "--policy", "none", *arguments]) == 2
    assert words in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_watch_writes_a_file_where_no_window_opens(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pygame", None)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert cli.main(["watch", "--policy", "none", *SHORT]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("encounter 9: none cost") and "No window can be opened" in err
    assert [path.name for path in tmp_path.glob("*/*")] == ["encounter-9.gif"]


@pytest.mark.slow
def test_watch_shows_so_many_encounters(monkeypatch, capsys):
    shown = []

    class Screen:
        is_closed = is_unseen = False

        def __init__(self, title):
            pass

        def show(self, frame, fps):
            shown.append(frame.shape)

        def close(self):
            shown.append("closed")

    monkeypatch.setattr("rss_gym.render.window.Window", Screen)
    assert cli.main(["watch", "--policy", "none", *SHORT, "--encounters", "2"]) == 0
    assert shown[-1] == "closed" and set(shown[:-1]) == {(334, 400, 3)}
    assert [line.partition(":")[0] for line in capsys.readouterr().out.splitlines()] == ["encounter 9", "encounter 10"]
