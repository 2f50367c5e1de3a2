"""Estimators of range from RSS: one file each, pure kernels; `RANGE_ESTIMATORS` gives each its code in the records."""

from typing import Final

COLOURED: Final = 0
WHITE: Final = 1
LEAST_SQUARES: Final = 2
WHITE_R: Final = 3

RANGE_ESTIMATORS: dict[str, int] = {
    "ekf-coloured": COLOURED,
    "ekf-white": WHITE,  # of the whole variance, R + S
    "ekf-white-r": WHITE_R,  # of R alone: what the paper compares with
    "ls": LEAST_SQUARES,
}
