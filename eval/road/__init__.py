"""Scores on the roads of highway-env, by the metrics and intervals of the world."""

from rss_gym.eval.road.evaluate import check, evaluate
from rss_gym.eval.road.output import COLUMNS, save
from rss_gym.eval.road.suites import SUITES

__all__ = ["COLUMNS", "SUITES", "check", "evaluate", "save"]
