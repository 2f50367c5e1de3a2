"""The radio of the paper: its four numbers come out together."""

from __future__ import annotations

import numpy as np

from rss_gym.eval.paper.study import METHODS, QUICK, Study
from rss_gym.eval.studies.section import Criterion, Section

# Method of the paper's page, what the paper states of its 80 % error, and how closely a curve can be read.
STATED_M = {"ls": 10.0, "white-r": 8.5, "coloured": 4.0, "coloured-velocity": 1.7}
READ = 0.15


def section() -> Section:
    """80 % range errors on the twelve flights, each filter with the process noise that serves it best but one.

    "The other parameters were the same": the white filter with R alone flies with the coloured filter's process noise.
    """
    study = Study(QUICK)
    rows, criteria = [], []
    for name, stated in STATED_M.items():
        method = METHODS[name]
        noise = study.noise_m2_ps("coloured" if name == "white-r" else name)
        errors = np.quantile(study.flown.errors_m(method, study.channel, noise), 0.8, axis=1)
        low, middle, high = np.quantile(errors, [0.025, 0.5, 0.975])
        rows.append([method.label, f"{stated:g}", f"{middle:.2f} [{low:.2f}, {high:.2f}]"])
        met = abs(middle - stated) <= READ * stated
        criteria.append(Criterion(f"{method.label}: {stated:g} m within {READ:.0%}", f"{middle:.2f} m", met))
    return Section(
        "The radio of the paper",
        "The 80 % error is the range error that 80 % of the samples stay below. It is measured on the twelve "
        f"flights of the paper with the channel `paper`, {study.size.repetitions} times with new noise: the median, "
        "and the interval of 95 % of the repetitions.",
        ("estimator", "paper, m", "here, m"),
        rows,
        criteria,
    )
