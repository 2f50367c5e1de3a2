"""Scripted drivers for the roads of highway-env; a new one is one file and one line in `POLICIES`."""

from rss_gym.baselines.policy import Scripted
from rss_gym.baselines.road.policy import Idm, Nothing
from rss_gym.baselines.road.rule import Rule

POLICIES: dict[str, type[Scripted]] = {"none": Nothing, "rule": Rule, "idm": Idm}
