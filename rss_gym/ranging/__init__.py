"""Estimators of range from RSS: one file each, pure kernels; `ESTIMATORS` is the list of them all.

A new one is one file and one line there, or `rss_gym.register_estimator`: by its `Filter` it flies in the world, runs
over records (`rss_gym.ranging.track`), and is compared by `rss-gym calibrate`.
"""

from rss_gym.ranging import filters, log_distance, window
from rss_gym.ranging.estimator import COLOURED, LEAST_SQUARES, WHITE, WHITE_R, Estimator, Filter, check
from rss_gym.registry import Registry

__all__ = [
    "COLOURED",
    "ESTIMATORS",
    "LEAST_SQUARES",
    "WHITE",
    "WHITE_R",
    "Estimator",
    "Filter",
    "RangeTrack",
    "Tuning",
    "track",
]

_SHIPPED: dict[str, Estimator] = {
    "ls": Estimator(
        "least squares, each sample", run=filters.run_inverse, white_is_total=True, tuned=False, code=LEAST_SQUARES
    ),
    "ls-window": Estimator("least squares, mean of 5 s", run=window.run, tuned=False),
    # Of R alone: what the paper compares with.
    "ekf-white-r": Estimator("white EKF, R alone", run=filters.run_white, code=WHITE_R),
    "ekf-white": Estimator("white EKF, R + S", run=filters.run_white, white_is_total=True, code=WHITE),
    "ekf-white-literal": Estimator(
        "white EKF, literal start", run=filters.run_white, white_is_total=True, literal=True, compared=False
    ),
    "ekf-coloured-literal": Estimator("coloured EKF, literal start", run=filters.run_coloured, literal=True),
    "ekf-coloured": Estimator("coloured EKF", run=filters.run_coloured, code=COLOURED),
    "ekf-log": Estimator(
        "coloured EKF, state ln d",
        Filter(
            log_distance.prior, log_distance.predict_state, log_distance.update_state, None, log_distance.innovation
        ),
        run=log_distance.run,
        logarithmic=True,
    ),
}

ESTIMATORS: Registry[Estimator] = Registry("estimator", _SHIPPED, check, like="my-filter")

from rss_gym.ranging.track import RangeTrack, Tuning, track  # noqa: E402 (it needs the list)
