"""Every policy and every estimator has one colour, which the style sheet knows."""

import re

from rss_gym import baselines
from rss_gym.eval import evaluate
from rss_gym.eval.report import series
from rss_gym.pages import colours, figure
from rss_gym.ranging import ESTIMATORS

BLIND = {"constant", "velocity", "climb", "stop", "back", "blind", "brake", "right-turn", "random"}


def test_rules_and_agents_have_a_colour():
    assert set(colours.POLICIES) == ({*baselines.POLICIES} | {*baselines.AGENTS}) - BLIND
    assert set(colours.ESTIMATORS) <= set(ESTIMATORS)
    assert {*colours.POLICIES.values(), *colours.ESTIMATORS.values()} <= {*colours.CLASSES, colours.NOMINAL}


def test_colours_are_those_of_the_style_sheet():
    assert set(figure.CLASSES) >= {*colours.CLASSES, colours.NOMINAL}
    assert all(re.fullmatch("#[0-9a-f]{3}|#[0-9a-f]{6}", value) for value in colours.light().values())
    assert colours.of_policy("orca:radius_m=20") == colours.of_policy("orca@oracle") == colours.light()["c1"]
    settings = figure.light()
    assert settings["text.color"] == colours.light()["ink"] and "#010101" not in settings.values()


def test_a_report_gives_a_policy_its_own_colour_whatever_is_beside_it():
    for policies in (["orca", "mpc"], ["mpc", "velocity", "orca"]):
        result = evaluate(policies, episodes=20, progress=False)
        names = [scored.entry.name for scored in result.policies]
        found = dict(zip(names, series.of(result).classes, strict=True))
        assert (found["none"], found["orca"], found["mpc"]) == ("nominal", "c1", "c4")
        assert len(set(found.values())) == len(names)


def test_a_curve_has_one_colour_and_a_second_entry_of_a_rule_another():
    result = evaluate(["orca:radius_m=20", "orca:radius_m=30"], episodes=20, progress=False)
    assert [*series.of(result).classes] == ["nominal", "c1", "c1"]
    result = evaluate({"mine": "orca", "orca": "orca"}, episodes=20, progress=False)
    assert [*series.of(result).classes] == ["nominal", "c0", "c1"]
