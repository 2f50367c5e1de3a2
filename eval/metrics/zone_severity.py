"""How deep flights go into the safety zone."""

from functools import partial

import numpy as np

from rss_gym.eval.intervals import Interval, quantile_order_statistics
from rss_gym.eval.metrics.metric import ONE, Flights, Metric


def zone_severity(flights: Flights, q: float) -> Interval:
    """Quantile over all encounters of max(0, 1 - least separation / S); 0 is outside the zone, 1 is contact.

    After the severity of loss of well clear (SLoWC) of MIT-LL's degas-core, on the zone of (40). Order statistics.
    """
    severity = np.maximum(0.0, 1.0 - flights.table["min_separation_m"] / flights.suite_radius_m)
    return quantile_order_statistics(severity, q, lowest=0.0, highest=1.0)


ZONE_SEVERITY_P50 = Metric("depth of zone entry (0 outside, 1 contact), median", ONE, partial(zone_severity, q=0.5))
ZONE_SEVERITY_P95 = Metric(
    "depth of zone entry (0 outside, 1 contact), 95 % quantile", ONE, partial(zone_severity, q=0.95)
)
