"""The evaluator: suites, flights, metrics with intervals, records."""

from rss_gym.eval.evaluate import Result, evaluate

__all__ = ["Result", "evaluate"]
