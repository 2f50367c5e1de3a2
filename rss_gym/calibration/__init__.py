"""Readers of radio logs, and the fit; `rss_gym.eval.studies.calibration` compares the estimators on them."""
