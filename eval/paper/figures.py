"""The figures in the order of the page; a new one is one function and one line."""

from __future__ import annotations

from collections.abc import Callable

from rss_gym.eval.paper import collisions, contrast, errors, rule, scan, signal, variants, zone
from rss_gym.eval.paper.panel import Panel
from rss_gym.eval.paper.study import Study

FIGURES: dict[str, Callable[[Study], Panel]] = {
    "2": signal.segment,
    "3": signal.allan,
    "4": zone.zone,
    "5-10": errors.cdf,
    "6": rule.drawing_of_rule,
    "8": errors.paths,
    "9": errors.distance,
    "11a": variants.noise,
    "11a-scan": scan.scan,
    "11a-radios": contrast.contrast,
    "11b": variants.path_loss_factor,
    "11c": variants.velocity,
    "12": collisions.collisions,
    "13": rule.trajectories,
    "14": rule.distances,
}
