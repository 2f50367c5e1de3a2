"""The leaderboard: what is merged, what is refused, and what a page from strangers' records can do to its reader."""

import dataclasses
import importlib
import json
import re
import shutil
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from markupsafe import escape

from rss_gym import baselines
from rss_gym.cli import main
from rss_gym.eval import evaluate
from rss_gym.eval.evaluate import score
from rss_gym.eval.leaderboard import build
from rss_gym.eval.policies import Entry
from rss_gym.eval.reading import RecordError, definition, load
from rss_gym.eval.records import save, table_digest, write_table
from rss_gym.eval.verify import verify
from rss_gym.params import ParamsError

sys.path.append(str(Path(__file__).parent))
flyers = importlib.import_module("flyers")

HTML = "<img src=x onerror=alert(1)>&\"'"


def scored(policies, folder, **keywords):
    return save(evaluate(policies, progress=False, **keywords), folder)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Official and other runs."""
    folder = tmp_path_factory.mktemp("runs")
    return {
        "official": scored(["none", "orthogonal", "orthogonal@oracle"], folder / "official", suite="smoke-v0"),
        "second": scored({"rule 80": "orthogonal:radius_m=80"}, folder / "second", suite="smoke-v0"),
        "short": scored(["orthogonal", "brake"], folder / "short", suite="smoke-v0", episodes=40),
        "seed 7": scored(["random"], folder / "seed 7", suite="smoke-v0", episodes=40, seed=7),
        "other suite": scored(["brake"], folder / "other", suite="encounter-v0", episodes=30),
        "html": scored({HTML: "brake"}, folder / "<b>&x", suite="smoke-v0", episodes=30, seed=9),
        "faulty": scored(["flyers:NanOnce"], folder / "faulty", suite="smoke-v0"),
    }


class Page(HTMLParser):
    """Tables of the page, each a list of rows of texts, under the last heading before them; and all links."""

    def __init__(self, file):
        super().__init__()
        self.tables, self.links, self.tags, self.heading, self.words = [], [], [], "", None
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag == "a":
            self.links.append(dict(attributes)["href"])
        if tag in ("h2", "h3", "td", "th", "p"):
            self.words = ""
        if tag == "table":
            self.tables.append((self.heading, []))
        if tag == "tr":
            self.tables[-1][1].append([])

    def handle_data(self, data):
        if self.words is not None:
            self.words += data

    def handle_endtag(self, tag):
        if tag == "h2":
            self.suite = self.words
        if tag == "h3":
            self.run = self.words
        if tag == "p" and self.words.startswith("Information"):
            self.heading = f"{self.suite} / {self.run} / {self.words.split(':')[0]}"
        if tag == "h2" and self.words == "Records":
            self.heading = "Records"
        if tag in ("td", "th"):
            self.tables[-1][1][-1].append(self.words)

    def names(self):
        """Heading -> names in order of place."""
        return {heading: [row[1] for row in rows[1:]] for heading, rows in self.tables if heading != "Records"}


def page(folders, out):
    site = build(folders, out)
    return Page(site.page), site.notes


def test_one_table_a_level_of_information_official_runs_first(runs, tmp_path):
    read, notes = page(runs.values(), tmp_path / "site")
    names = {
        heading: [re.sub(r"(orthogonal:radius_m=80; )?record.*", "", name) for name in names]
        for heading, names in read.names().items()
    }
    official = "Suite smoke-v0 / All encounters of the suite: 100 encounters of split suite, seed 0"
    assert list(names) == [
        "Suite encounter-v0 / Other runs: 30 encounters of split suite, seed 0 / Information positions",
        f"{official} / Information oracle",
        f"{official} / Information positions",
        "Suite smoke-v0 / Other runs: 40 encounters of split suite, seed 0 / Information positions",
        "Suite smoke-v0 / Other runs: 40 encounters of split suite, seed 7 / Information positions",
    ]
    assert names[f"{official} / Information oracle"] == ["orthogonal@oracle"]
    assert set(names[f"{official} / Information positions"]) == {"rule 80", "orthogonal", "none", "flyers:NanOnce"}
    assert names[f"{official} / Information positions"][-2:] == ["none", "flyers:NanOnce"]
    assert any("orthogonal (record 3) is left out: orthogonal (record 1)" in note for note in notes)


def test_a_policy_with_faults_is_not_ranked(runs, tmp_path):
    read, _ = page([runs["faulty"]], tmp_path / "site")
    text = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    (rows,) = [rows[1:] for heading, rows in read.tables if heading != "Records"]
    assert rows[-1][0] == "–" and re.search(r"not ranked: \d+ faults?; .*a claim", rows[-1][1])
    assert rows[0][0] == "1*"
    (red,) = [markup for markup in re.findall("<tr.*?</tr>", text, re.DOTALL) if 'class="fault"' in markup]
    assert "flyers:NanOnce" in red and red.startswith('<tr class="fault">')
    assert "tr.fault" in text and "color: var(--red)" in text


def test_rows_are_in_order_of_cost_with_the_difference_from_the_first(runs, tmp_path):
    read, _ = page([runs["official"], runs["second"]], tmp_path / "site")
    headings, *rows = read.tables[1][1]
    assert headings[2:5] == ["cost (m)", "more than the first (m)", "collision rate"]
    assert headings[5:] == ["sNMAC rate", "path deviation mean (m)", "unnecessary manoeuvre rate", "zone severity",
                            "path regained rate", "faults"]  # fmt: skip
    costs = {row[1]: float(re.match("[0-9.,]+", row[2])[0].replace(",", "")) for row in rows}
    assert list(costs.values()) == sorted(costs.values()) and rows[0][3] == "" and rows[-1][1].startswith("none")
    for row in rows[1:]:
        more = float(re.match("[0-9.,]+", row[3])[0].replace(",", ""))
        assert more == pytest.approx(costs[row[1]] - costs[rows[0][1]], rel=0.02)


def test_records_are_copied_and_linked(runs, tmp_path):
    site = tmp_path / "site"
    read, _ = page([runs["official"], runs["seed 7"]], site)
    links = [link for link in read.links if not link.startswith("#")]
    assert "records/1-official/scores.json" in links and "records/2-seed-7/tables/01-random.npz" in links
    assert all((site / link).is_file() for link in links)
    assert verify(site / "records" / "2-seed-7").verified
    files = {path.name for path in (site / "records" / "1-official").rglob("*") if path.is_file()}
    assert files == {"scores.json", "00-none.npz", "01-orthogonal.npz", "02-orthogonal-oracle.npz"}


def test_a_strangers_page_is_not_copied(runs, tmp_path):
    folder = shutil.copytree(runs["short"], tmp_path / "run")
    (folder / "report.html").write_text("<script>alert(1)</script>")
    (folder / "tables" / "evil.npz").write_text("")
    build([folder], tmp_path / "site")
    assert not list((tmp_path / "site").rglob("report.html")) and not list((tmp_path / "site").rglob("evil*"))


def test_names_are_text(runs, tmp_path):
    site = tmp_path / "site"
    read, _ = page([runs["html"]], site)
    assert "img" not in read.tags and "b" not in read.tags
    assert any(HTML in name for names in read.names().values() for name in names)
    assert [path.name for path in (site / "records").iterdir()] == ["1--b-x"]


def test_the_page_needs_no_network(runs, tmp_path):
    text = build([runs["html"]], tmp_path / "site").page.read_text(encoding="utf-8")
    assert "http://" not in text and "https://" not in text and "default-src 'none'" in text


@pytest.mark.slow
def test_the_same_records_give_the_same_page(runs, tmp_path):
    folders = [runs["official"], runs["short"]]
    one, other = (build(folders, tmp_path / name).page.read_bytes() for name in ("one", "other"))
    assert one == other


# Merging


def test_two_definitions_of_one_suite_are_not_merged(runs, tmp_path):
    """A foreign world under a suite's name shares no table with it, and says what it is."""
    other = scored(["brake"], tmp_path / "other", suite="smoke-v0", episodes=20, channel="quadcopter")
    read, _ = page([runs["official"], other], tmp_path / "site")
    names = {heading: names for heading, names in read.names().items() if "not the suite's" in heading}
    ((heading, rows),) = names.items()
    assert heading.startswith("Suite smoke-v0 / Other runs: 20 encounters") and len(rows) == 2


def test_an_older_definition_is_set_aside(runs, tmp_path, monkeypatch):
    from rss_gym import domain

    monkeypatch.setattr(domain, "WORLD_VERSION", domain.WORLD_VERSION + 1)
    with pytest.raises(RecordError, match=r"suite_hash of 'smoke-v0'.*use the version of rss-gym that wrote"):
        build([runs["official"]], tmp_path / "site")


@pytest.mark.parametrize("reverse", [False, True])
def test_the_official_then_the_longer_run_is_kept(runs, tmp_path, reverse):
    folders = [runs["short"], runs["official"], scored(["brake"], tmp_path / "longer", suite="smoke-v0", episodes=60)]
    _, notes = page(folders[::-1] if reverse else folders, tmp_path / "site")
    lines = "\n".join(notes)
    assert re.search(r"orthogonal \(record \d\) is left out: .* on all encounters of the suite", lines)
    assert re.search(r"brake \(record \d\) is left out: .* on 60 encounters instead of 40", lines)
    assert lines.count("none (record") == 4  # two left out for one


def test_the_same_record_twice(runs, tmp_path):
    _, notes = page([runs["short"], runs["short"]], tmp_path / "site")
    assert len(notes) == 3 and all("left out" in note for note in notes)
    assert [path.name for path in (tmp_path / "site" / "records").iterdir()] == ["1-short"]


def edited(folder, to, edit):
    shutil.copytree(folder, to)
    content = json.loads((to / "scores.json").read_text())
    edit(content)
    (to / "scores.json").write_text(json.dumps(content))
    return to


def test_code_of_one_name_is_listed_once_a_record(tmp_path):
    """Two laboratories may both have a policy `mine:policy`."""

    def scored_as(kind, name):
        run = scored({"mine": f"flyers:{kind}"}, tmp_path / f"{name}-as-flown", suite="smoke-v0", episodes=20)
        digest = load(run)["mine"].hash
        edit = lambda content: content["policies"][1].update(spec="mine:policy", hash="5" * 64)  # noqa: E731
        assert digest != "5" * 64
        return edited(run, tmp_path / name, edit)

    one, same, other = scored_as("Flyer", "one"), scored_as("Sleeper", "same"), scored_as("Crowd", "other")
    read, notes = page([one, same, other], tmp_path / "site")
    (names,) = read.names().values()
    assert len(names) == 4 and [sum(f"record {n}" in name for name in names) for n in (1, 2, 3)] == [2, 1, 1]
    assert any("mine (record 3) and mine (record 1) have one hash" in note for note in notes)


def test_a_rule_with_other_information_is_one_policy_over_other_encounters_too(runs, tmp_path):
    """Of whatever is not the package's, both rows are listed."""
    other = scored(["orthogonal@oracle"], tmp_path / "other", suite="smoke-v0", episodes=20, seed=9)
    notes = build([runs["official"], other], tmp_path / "site").notes
    assert [note for note in notes if note.startswith("orthogonal@oracle") and "is left out" in note]


@pytest.mark.slow
@pytest.mark.parametrize("ulps", [0, 1])
@pytest.mark.parametrize("reverse", [False, True])
def test_of_records_that_contradict_each_other_the_flights_decide(runs, tmp_path, reverse, ulps):
    """Flights of another rule, or one value that is an ulp off: the false record is set aside, in whatever order."""
    if ulps:
        false = shutil.copytree(runs["official"], tmp_path / "false")
        forge_one_ulp(false)
    else:
        run = scored({"none": "none", "orthogonal": "orthogonal:radius_m=20"}, tmp_path / "run", suite="smoke-v0")
        true = load(runs["official"])["orthogonal"]
        false = edited(run, tmp_path / "false", lambda c: c["policies"][1].update(spec=true.spec, hash=true.hash))
    folders = [runs["official"], false]
    site = build(folders[::-1] if reverse else folders, tmp_path / "site", seed=3)
    (why,) = site.quarantined
    assert why.startswith(f"{false}: policy 'orthogonal', episode ")
    read = Page(site.page)
    assert [name for names in read.names().values() for name in names if name.startswith("orthogonalr")]
    assert "Set aside" in site.page.read_text(encoding="utf-8")


def forge_one_ulp(folder):
    """Griefing: a rival's row is no more what it was, by the last bit of a column that no metric of the board shows."""
    record = load(folder)
    policy = record["orthogonal"]
    table = policy.table
    table["flown_m"][71] = np.nextafter(table["flown_m"][71], np.inf)
    write_table(folder / "tables", Path(policy.file).stem, table, with_csv=False)
    suite = definition(record)
    entries = [Entry(one.name, one.spec, None, suite.params) for one in record.policies]
    result = score(suite, record.seed, entries, [one.table for one in record.policies], record.reference, True)

    def edit(content):
        content["policies"][1]["table_sha256"] = table_digest(table)
        for item, one in zip(content["policies"], result.policies, strict=True):
            item["metrics"] = {name: dataclasses.asdict(estimate) for name, estimate in one.metrics.items()}

    content = json.loads((folder / "scores.json").read_text())
    edit(content)
    (folder / "scores.json").write_text(json.dumps(content))


def test_nobody_takes_the_place_of_anothers_policy(tmp_path):
    """Hijack: a rival's learned policy under another name, on more encounters. Both rows are listed."""
    agent = str(baselines.AGENTS["ppo-plane"])
    one = scored({"mine": agent}, tmp_path / "one", suite="smoke-v0", episodes=10)
    other = scored({"stolen": agent}, tmp_path / "other", suite="smoke-v0", episodes=20)
    read, notes = page([one, other], tmp_path / "site")
    names = [name for names in read.names().values() for name in names]
    assert any(name.startswith("mine") for name in names) and any(name.startswith("stolen") for name in names)
    assert any("have one hash and may be one policy" in note for note in notes)


def test_a_relabelled_seed_is_set_aside(runs, tmp_path):
    """Encounters of a lucky seed under the suite's own."""
    lucky = edited(runs["seed 7"], tmp_path / "lucky", lambda content: content.update(seed=0))
    (why,) = build([runs["short"], lucky], tmp_path / "site").quarantined
    assert why.startswith(str(lucky)) and "episode" in why


def test_a_world_too_costly_to_fly_is_set_aside(runs, tmp_path):
    costly = scored(["none"], tmp_path / "costly", suite="smoke-v0", episodes=1, tail_max_s=300.0, tick_s=0.01)
    assert "too costly" in build([runs["short"], costly], tmp_path / "site").quarantined[0]


def test_a_claim_has_no_place(runs, tmp_path):
    """An invented table of what cannot be flown again, beside an honest row that costs more."""
    read, _ = page([runs["faulty"], runs["official"]], tmp_path / "site")
    ((*_, last),) = [rows for heading, rows in read.tables if "NanOnce" in str(rows) and heading != "Records"]
    assert last[0] == "–" and "a claim" in last[1]


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda c: c["policies"][1]["metrics"]["cost_m"].update(value=1e-6), "cost_m.value"),
        (lambda c: c["policies"][1]["metrics"].pop("faults"), "faults"),
        (lambda c: c.update(official=False), "official = False must be True"),
        (lambda c: c["policies"][1].update(information="ranges"), "information"),
        (lambda c: c["policies"][1].update(hash="0" * 64), "hash"),
        (lambda c: c["params"]["zone"].update(collision_m=4.4), "collision"),
        (lambda c: c["params"]["reward"].update(comfort_m=4.4), "suite_hash"),
        (lambda c: c.update(seed=NotImplemented), "not JSON"),
    ],
)
def test_forged_claims_are_set_aside(runs, tmp_path, edit, words):
    try:
        forged = edited(runs["official"], tmp_path / "forged", edit)
    except TypeError:  # what JSON cannot hold
        forged = tmp_path / "forged"
        (forged / "scores.json").write_text("{broken")
    site = build([runs["short"], forged], tmp_path / "site")
    (why,) = site.quarantined
    assert re.search(words, why) and str(forged) in why
    assert str(escape(why)) in site.page.read_text(encoding="utf-8") and not list((tmp_path / "site").rglob("*forged*"))


def test_leaderboards_run_no_code(tmp_path, runs, monkeypatch):
    (tmp_path / "trap.py").write_text(f"import os\nos.mkdir({str(tmp_path / 'sprung')!r})\n")
    monkeypatch.syspath_prepend(tmp_path)
    build(
        [edited(runs["faulty"], tmp_path / "run", lambda c: c["policies"][1].update(spec="trap:x"))], tmp_path / "site"
    )
    assert not (tmp_path / "sprung").exists()


# The command


def run(capsys, *arguments):
    status = main(["leaderboard", *map(str, arguments)])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_the_command(runs, tmp_path, capsys):
    status, out, _ = run(capsys, runs["official"], runs["short"], "--out", tmp_path / "site")
    assert (
        status == 0 and "left out" in out and out.splitlines()[-1] == f"leaderboard: {tmp_path / 'site' / 'index.html'}"
    )
    status, _, err = run(capsys, runs["official"], "--out", tmp_path / "site")
    assert status == 2 and "exists" in err
    status, _, err = run(capsys, tmp_path, "--out", tmp_path / "site2")
    assert status == 2 and "scores.json is missing" in err and len(err.splitlines()) == 1


def test_an_unwritable_site_is_refused(runs, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ParamsError, match="cannot be written"):
        build([runs["short"]], tmp_path / "file" / "site")
