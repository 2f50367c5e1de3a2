"""The script of `make table`: nothing that can fly is left out, and a chart of any numbers is a picture."""

from xml.etree import ElementTree

import opponents
import pytest
import table

from rss_gym.baselines import POLICIES
from rss_gym.eval.metrics import Estimate


def test_every_policy_is_flown_on_every_track_that_it_can_fly_on():
    jobs = table.jobs(1)
    flown = {(job.changes.get("track", "paper"), spec.partition(":")[0]) for job in jobs for spec in job.policies}
    assert flown >= {(track, name) for name, kind in POLICIES.items() for track in kind.tracks if not kind.in_space}
    assert ("paper", "climb") in flown


def test_no_two_jobs_share_a_folder_and_the_chosen_settings_have_the_most_encounters():
    jobs = table.jobs(1)
    assert len({job.folder for job in jobs}) == len(jobs)
    for track in table.CURVES:
        main = next(job for job in jobs if job.name == track)
        assert main.episodes == 100_000 and set(table.chosen(track, slow=False)) <= set(main.policies)


def test_the_chart_draws_points_without_a_collision():
    pytest.importorskip("matplotlib")

    def row(rate, deviation_m):
        high = max(2.0 * rate, 1e-3)
        metrics = {
            "collision_rate": Estimate(rate, 0.5 * rate, high, 1000, "1"),
            "path_deviation_mean_m": Estimate(deviation_m, deviation_m, deviation_m, 1000, "m"),
        }
        return opponents.Row("orca", 1000, metrics)

    curves = {track: {"orca": [row(0.1, 3.0), row(0.0, 20.0)]} for track in table.CURVES}
    drawn = opponents.chart(curves, dict.fromkeys(curves, row(0.4, 22.0)))
    assert ElementTree.fromstring(drawn).tag == "{http://www.w3.org/2000/svg}svg"
    assert "--c0: #" in drawn and "track oracle" in drawn
