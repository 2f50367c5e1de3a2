"""Calibration of a channel from radio logs: readers, the fit, and the estimators compared on held-out flights."""
