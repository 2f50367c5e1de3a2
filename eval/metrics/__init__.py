"""The scores of the evaluator.

A new metric is one file with a `Metric` and one line in `METRICS`, or `rss_gym.register_metric`. Reports and records
list them in this order.
"""

from __future__ import annotations

from collections.abc import Iterable

from rss_gym.eval.metrics.alert_lead_time import ALERT_LEAD_TIME_P5_S, ALERT_LEAD_TIME_P50_S, NEVER_ALERTED_RATE
from rss_gym.eval.metrics.cost import COST_M
from rss_gym.eval.metrics.event_rate import COLLISION_RATE, SNMAC_RATE, ZONE_VIOLATION_RATE
from rss_gym.eval.metrics.extra_path import EXTRA_PATH
from rss_gym.eval.metrics.false_alert_rate import FALSE_ALERT_RATE_PH
from rss_gym.eval.metrics.faults import FAULTS
from rss_gym.eval.metrics.metric import Estimate, Flights, Function, Metric
from rss_gym.eval.metrics.min_separation import (
    MIN_SEPARATION_P0_1_M,
    MIN_SEPARATION_P1_M,
    MIN_SEPARATION_P5_M,
    MIN_SEPARATION_P50_M,
)
from rss_gym.eval.metrics.missed_detection import (
    LATE_WARNING_RATE,
    MISSED_DETECTION_BOUND,
    MISSED_DETECTION_DECISION_RATE,
    MISSED_DETECTION_ENCOUNTER_RATE,
)
from rss_gym.eval.metrics.off_the_plan import LANE_DEVIATION_M, SPEED_DEVIATION_MPS
from rss_gym.eval.metrics.path_deviation import (
    PATH_DEVIATION_COMPLETED_M,
    PATH_DEVIATION_MAX_M,
    PATH_DEVIATION_MEAN_M,
    PATH_REGAINED_RATE,
)
from rss_gym.eval.metrics.range_error import RANGE_ERROR_P50_M, RANGE_ERROR_P80_M, RANGE_RMSE_M
from rss_gym.eval.metrics.risk_ratio import RISK_RATIO, RISK_RATIO_INDUCED, RISK_RATIO_UNRESOLVED
from rss_gym.eval.metrics.unnecessary_manoeuvre_rate import UNNECESSARY_MANOEUVRE_RATE
from rss_gym.eval.metrics.zone_severity import ZONE_SEVERITY
from rss_gym.params import ParamsError
from rss_gym.registry import Registry

__all__ = ["METRICS", "Estimate", "Flights", "Function", "Metric", "defined_in", "measure"]

_SHIPPED: dict[str, Metric] = {
    "cost_m": COST_M,
    "collision_rate": COLLISION_RATE,
    "snmac_rate": SNMAC_RATE,
    "zone_violation_rate": ZONE_VIOLATION_RATE,
    "zone_severity": ZONE_SEVERITY,
    "faults": FAULTS,
    "risk_ratio": RISK_RATIO,
    "risk_ratio_unresolved": RISK_RATIO_UNRESOLVED,
    "risk_ratio_induced": RISK_RATIO_INDUCED,
    "unnecessary_manoeuvre_rate": UNNECESSARY_MANOEUVRE_RATE,
    "alert_lead_time_p50_s": ALERT_LEAD_TIME_P50_S,
    "alert_lead_time_p5_s": ALERT_LEAD_TIME_P5_S,
    "never_alerted_rate": NEVER_ALERTED_RATE,
    "path_deviation_mean_m": PATH_DEVIATION_MEAN_M,
    "path_deviation_max_m": PATH_DEVIATION_MAX_M,
    "path_deviation_completed_m": PATH_DEVIATION_COMPLETED_M,
    "path_regained_rate": PATH_REGAINED_RATE,
    "extra_path": EXTRA_PATH,
    "min_separation_p0_1_m": MIN_SEPARATION_P0_1_M,
    "min_separation_p1_m": MIN_SEPARATION_P1_M,
    "min_separation_p5_m": MIN_SEPARATION_P5_M,
    "min_separation_p50_m": MIN_SEPARATION_P50_M,
    "range_error_p50_m": RANGE_ERROR_P50_M,
    "range_error_p80_m": RANGE_ERROR_P80_M,
    "range_rmse_m": RANGE_RMSE_M,
    "missed_detection_decision_rate": MISSED_DETECTION_DECISION_RATE,
    "missed_detection_encounter_rate": MISSED_DETECTION_ENCOUNTER_RATE,
    "late_warning_rate": LATE_WARNING_RATE,
    "missed_detection_bound": MISSED_DETECTION_BOUND,
    "false_alert_rate_ph": FALSE_ALERT_RATE_PH,
    "lane_deviation_m": LANE_DEVIATION_M,
    "speed_deviation_mps": SPEED_DEVIATION_MPS,
}


def _check(name: str, metric: Metric) -> None:
    if not isinstance(metric, Metric):
        raise ParamsError(f"metric {name!r} must be a rss_gym.eval.metrics.Metric, got {type(metric).__name__}")
    if not callable(metric.function):
        raise ParamsError(f"metric {name!r}: function must be callable, got {metric.function!r}")
    for field in ("summary", "unit"):
        if not isinstance(getattr(metric, field), str) or not getattr(metric, field).strip():
            raise ParamsError(f"metric {name!r}: {field} must be a text, got {getattr(metric, field)!r}")
    if not isinstance(metric.domains, tuple) or not metric.domains or not set(metric.domains) <= {"air", "road"}:
        raise ParamsError(f"metric {name!r}: domains must hold 'air', 'road' or both, got {metric.domains!r}")


METRICS: Registry[Metric] = Registry("metric", _SHIPPED, _check, name="[a-z][a-z0-9_]*", like="my_metric_m")


def defined_in(domain: str) -> dict[str, Metric]:
    """The metrics of a domain, in order."""
    return {name: metric for name, metric in METRICS.items() if domain in metric.domains}


def measure(flights: Flights, names: Iterable[str] | None = None) -> dict[str, Estimate]:
    """The metrics of these flights by name, those named or all of their domain.

    Raises
    ------
    ParamsError
        For an unknown name.
    """
    chosen = defined_in(flights.domain) if names is None else names
    return {name: METRICS.find(name)(flights) for name in chosen}
