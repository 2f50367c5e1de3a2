"""The study of the policies: nothing that can fly is left out, and a chart of any numbers is a picture."""

from xml.etree import ElementTree

from rss_gym.baselines import POLICIES
from rss_gym.eval import evaluate, records
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.studies import study
from rss_gym.eval.studies.opponents import jobs, page


def test_every_policy_is_flown_on_every_information_that_it_can_fly_on():
    todo = jobs.planned()
    flown = {(job.name, spec.partition(":")[0]) for job in todo for spec in job.policies}
    planar = {(level, name) for name, kind in POLICIES.items() for level in kind.information if not kind.in_space}
    assert flown >= planar
    assert ("space", "climb") in flown


def test_no_two_jobs_share_a_folder_and_the_readme_has_the_most_encounters():
    todo = jobs.planned()
    assert len({job.folder for job in todo}) == len(todo)
    assert todo[0].name == "readme" and todo[0].episodes == max(job.episodes for job in todo)


def test_a_record_becomes_a_ranked_table(tmp_path):
    policies = ("none", "orca:radius_m=20", "stop")
    records.save(evaluate(policies, episodes=40, progress=False), tmp_path / "record")
    lines = page.ranked([tmp_path / "record"]).splitlines()
    assert lines[0].startswith("| place | policy | cost, m | more than the first, m | collisions |")
    assert lines[2].startswith("| 1 * | `orca:radius_m=20` |") and len(lines) == 5
    assert page.short([tmp_path / "record"]).splitlines()[0] == (
        "| policy | cost, m | collisions, % | near collisions, % | mean distance from the path, m |"
    )
    order = [line.split("`")[1] for line in page.short([tmp_path / "record"]).splitlines()[2:]]
    assert order == ["orca:radius_m=20", "stop", "none"]
    family = page.by_family({"mixed": study.read([tmp_path / "record"])})
    assert "| mixed | " in family and "**" in family


def test_the_chart_draws_points_without_an_event():

    def row(rate, deviation_m):
        high = max(2.0 * rate, 1e-3)
        metrics = {
            "snmac_rate": Estimate(rate, 0.5 * rate, high, 1000, "1"),
            "path_deviation_mean_m": Estimate(deviation_m, deviation_m, deviation_m, 1000, "m"),
        }
        return study.ScoreRow("orca", 1000, metrics)

    curves = {level: {"orca": [row(0.1, 3.0), row(0.0, 20.0)]} for level in jobs.RADII}
    drawn = page.chart(curves, dict.fromkeys(curves, row(0.4, 22.0)))
    assert ElementTree.fromstring(drawn).tag == "{http://www.w3.org/2000/svg}svg"
    assert "--c0: #" in drawn and "information: oracle" in drawn
