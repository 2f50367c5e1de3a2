"""Score policies: suites of encounters, flights, metrics with intervals, and records."""

from rss_gym.eval.evaluate import Result, evaluate
from rss_gym.eval.parts import Part, fly, merge

__all__ = ["Part", "Result", "evaluate", "fly", "merge"]
