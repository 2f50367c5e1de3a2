"""Evaluation: suites, episodes, metrics, intervals and reports."""
