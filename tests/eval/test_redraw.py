"""A page is a function of its record: drawn again it has the same bytes, and what is wrong is one sentence."""

import json
import shutil

import numpy as np
import pytest

from rss_gym.cli import main
from rss_gym.eval import evaluate, fly, merge, records, report
from rss_gym.eval.reading import RecordError, load, read_flights
from rss_gym.eval.redraw import redraw
from rss_gym.eval.report import replay
from rss_gym.eval.verify import report as verify_report
from rss_gym.eval.verify import verify


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    result = evaluate(["none", "orthogonal:radius_m=40", "brake", "orca@oracle"], episodes=12, progress=False)
    return records.save(result, tmp_path_factory.mktemp("sound") / "run", page=report.write)


@pytest.fixture
def folder(sound, tmp_path):
    """A copy to spoil."""
    return shutil.copytree(sound, tmp_path / "run")


def no_flight(*_, **__):
    raise AssertionError("a page is drawn again without a flight")


def again(folder, monkeypatch):
    """What the command writes, while nothing can fly."""
    monkeypatch.setattr(replay, "fly_episodes", no_flight)
    before = (folder / "report.html").read_bytes()
    (folder / "report.html").write_text("older")
    assert main(["report", str(folder)]) == 0
    return before, (folder / "report.html").read_bytes()


def test_the_page_has_the_same_bytes(folder, monkeypatch, capsys):
    before, after = again(folder, monkeypatch)
    assert after == before and b"orca@oracle" in after
    assert capsys.readouterr().out == f"report: {folder / 'report.html'}\n"


@pytest.mark.parametrize(
    ("policies", "settings"),
    [
        (["mpc"], {"episodes": 2, "suite": "encounter3d-v0"}),
        (["modified-orthogonal"], {"episodes": 3, "suite": "range-only-v0", "channel": "outdoor"}),
        (["brake"], {"episodes": range(5, 9), "intruders": 3, "action": "discrete"}),
        pytest.param(["rule"], {"episodes": 3, "suite": "highway-v0"}, marks=pytest.mark.slow),
    ],
    ids=["space", "range only", "a part", "road"],
)
def test_so_has_that_of_any_world(policies, settings, tmp_path, monkeypatch):
    result = evaluate(policies, progress=False, **settings)
    before, after = again(records.save(result, tmp_path / "run", page=report.write), monkeypatch)
    assert after == before


class Clumsy:
    """Fails whenever it is flown again."""

    flights = 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.flights += int(np.any(episode_start))
        if self.flights > 1:
            raise RuntimeError("<b>no</b>")
        return np.full((len(observation), 2), np.nan), None


def test_a_policy_that_failed_stays_so(tmp_path, monkeypatch):
    result = evaluate({"clumsy": Clumsy()}, episodes=3, progress=False)
    before, after = again(records.save(result, tmp_path / "run", page=report.write), monkeypatch)
    assert after == before and b"Not flown again: policy &#39;clumsy&#39; raised" in after


def test_the_flights_are_those_of_the_tables(sound):
    record, flown = load(sound), read_flights(load(sound))
    for (name, episode), flight in flown.flights.items():
        row = record[name].table[episode]
        assert flight["same"] and flight["least"][-1] == round(100 * row["min_separation_m"])
    assert {name for name, _ in flown.flights} == {policy.name for policy in record.policies}


def test_a_record_without_flights_says_so(tmp_path):
    result = merge([fly("brake", episodes=range(3)), fly("brake", episodes=range(3, 6))])
    folder = records.save(result, tmp_path / "run")
    page = redraw(folder).read_text(encoding="utf-8")
    assert page.count(replay.NOTHING) == 1 and 'id="data-replays"' not in page and 'id="player"' not in page
    assert "Safety against deviation" in page and "brake" in page


def test_a_record_of_before_is_drawn(folder):
    """Schema 3 had neither flights nor the actions of policies."""
    (folder / "flights.json").unlink()
    file = folder / "scores.json"
    content = json.loads(file.read_text())
    content["schema"] = 3
    for policy in content["policies"]:
        del policy["action"]
    file.write_text(json.dumps(content))
    assert load(folder).policies[1].action is None
    page = redraw(folder).read_text(encoding="utf-8")
    assert '<th scope="col" class="words">actions</th>' not in page and replay.NOTHING in page


def test_what_was_recorded_is_shown(folder):
    """Versions and hashes are those of the record, not those of who draws it."""
    file = folder / "scores.json"
    content = json.loads(file.read_text())
    content["versions"] = {"numpy": "1.2.3-then"}
    content["suite_hash"], content["policies"][1]["hash"] = "ab" * 32, "cd" * 32
    file.write_text(json.dumps(content))
    page = redraw(folder).read_text(encoding="utf-8")
    assert all(part in page for part in ("numpy 1.2.3-then", "ab" * 32, ("cd" * 32)[:16]))


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda c: c.update(format=2), ["format = 2", "1, which"]),
        (lambda c: c.update(more=1), ["'more' is unknown"]),
        (lambda c: c.update(flights={}), ["flights = {}", "list"]),
        (lambda c: c.update(failed=[1]), ["failed = [1]", "sentences"]),
        (lambda c: c["flights"].append(c["flights"][0]), ["policy 'none'", "twice"]),
        (lambda c: c["flights"][0].update(policy="nobody"), ["flights[0].policy = 'nobody'", "none"]),
        (lambda c: c["flights"][0].update(policy=[]), ["flights[0].policy = []"]),
        (lambda c: c["flights"][0].update(episode=12), ["flights[0].episode = 12", "[0, 11]"]),
        (lambda c: c["flights"][0].update(episode=True), ["flights[0].episode = True"]),
        (lambda c: c["flights"][0].update(intruders=[]), ["flights[0].intruders = []", "1 to 500"]),
        (lambda c: c["flights"][0].update(times=[1.0, 0.0]), ["flights[0].times", "do not fall"]),
        (lambda c: c["flights"][0]["times"].pop(), ["flights[0].least", "whole numbers"]),
        (lambda c: c["flights"][0]["own"].pop("planned"), ["flights[0].own.planned is missing"]),
        (lambda c: c["flights"][1]["own"]["position"].__setitem__(3, "x"), ["flights[1].own.position", "nulls"]),
        (lambda c: c["flights"][1]["intruders"][0].update(warning=None), ["flights[1].intruders[0].warning = None"]),
        (lambda c: c["flights"][1]["intruders"][0].update(rang=[]), ["rang", "did you mean 'range'"]),
    ],
    ids=range(16),
)
def test_flights_that_are_none(folder, edit, words, capsys):
    file = folder / "flights.json"
    content = json.loads(file.read_text())
    edit(content)
    file.write_text(json.dumps(content))
    before = (folder / "report.html").read_bytes()
    assert main(["report", str(folder)]) == 2
    said = capsys.readouterr().err.strip()
    assert "\n" not in said and str(file) in said and all(word in said for word in words), said
    assert (folder / "report.html").read_bytes() == before


def test_what_is_no_record(tmp_path, folder, capsys):
    assert main(["report", str(tmp_path / "nowhere")]) == 2
    assert "is not a folder" in capsys.readouterr().err
    (folder / "flights.json").unlink()
    (folder / "flights.json").symlink_to(folder / "gone.json")
    with pytest.raises(RecordError, match=r"flights\.json is a symbolic link"):
        redraw(folder)
    (folder / "flights.json").unlink()
    (folder / "flights.json").write_text('{"format": NaN}')
    with pytest.raises(RecordError, match=r"flights\.json: number NaN must be finite"):
        redraw(folder)


def test_information_that_the_world_does_not_give(folder):
    file = folder / "scores.json"
    file.write_text(file.read_text().replace('"information": "oracle"', '"information": "ranges"'))
    with pytest.raises(RecordError, match=r"scores\.json: information = 'ranges' of policy 'orca@oracle' must be one"):
        redraw(folder)


def edited(folder, change):
    file = folder / "flights.json"
    content = json.loads(file.read_text())
    change(content["flights"])
    file.write_text(json.dumps(content))


def test_kept_flights_are_flown_again(sound):
    verdict = verify(sound)
    assert verdict.verified and verdict.flights == 10
    assert "flights of the page: 10 flown again" in verify_report(verdict)


def shorter(flight):
    for name in ("times", "least"):
        flight[name].pop()
    for table in (flight["own"], *flight["intruders"]):
        for name, values in table.items():
            del values[-2 if name in ("position", "planned", "way_point", "message") else -1 :]


CHANGES = {
    "flight.own.position[": lambda flight: flight["own"]["position"].__setitem__(-1, 12345),
    "flight.intruders[0].warning[0]": lambda flight: flight["intruders"][0]["warning"].__setitem__(0, 7),
    "flight.least[0]": lambda flight: flight["least"].__setitem__(0, 3),
    "flight.collision": lambda flight: flight.update(collision=not flight["collision"]),
    "flight.same": lambda flight: flight.update(same=False),
    "flight.times[": lambda flight: flight["times"].__setitem__(-1, 1e6),
    "length of flight.times": shorter,
}


def test_a_flight_that_was_not_flown_is_named(folder, capsys):
    """A change a flight: each is found, and no other."""
    edited(folder, lambda flights: [change(flight) for change, flight in zip(CHANGES.values(), flights, strict=False)])
    flights = json.loads((folder / "flights.json").read_text())["flights"]
    verdict = verify(folder, every=True)
    assert verdict.flights == len(flights) > len(CHANGES)
    found = {}
    for one in verdict.differences:
        assert one.recorded != one.found
        found.setdefault((one.policy, one.episode), []).append(one.what)
    assert len(found) == len(CHANGES)
    for (what, change), flight in zip(CHANGES.items(), flights, strict=False):
        own = found[flight["policy"], flight["episode"]]
        assert any(one.startswith(what) for one in own) and (len(own) == 1 or change is shorter)
    assert main(["verify", str(folder), "--all"]) == 1
    out = capsys.readouterr().out
    assert all(what in out for what in CHANGES)


def test_a_flight_of_another_policy_is_seen(folder):
    names = set()

    def swap(flights):
        one = next(flight for flight in flights if flight["policy"] == "brake")
        two = next(f for f in flights if f["episode"] == one["episode"] and f is not one)
        one["policy"], two["policy"] = two["policy"], one["policy"]
        names.update((one["policy"], two["policy"]))

    edited(folder, swap)
    assert {one.policy for one in verify(folder, every=True).differences} == names


def test_a_flight_of_no_encounter_of_the_record_is_refused(folder, capsys):
    edited(folder, lambda flights: flights[0].update(episode=12))
    assert main(["verify", str(folder)]) == 2
    assert "flights.json: flights[0].episode = 12 must be a whole number in [0, 11]" in capsys.readouterr().err
