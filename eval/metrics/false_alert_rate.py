"""False alerts."""

from math import fsum

import numpy as np

from rss_gym.eval.intervals import Interval, overdispersion, poisson_rate
from rss_gym.eval.metrics.metric import Flights, Metric

HOUR_S = 3600.0


def false_alert_rate(flights: Flights) -> Interval:
    """Warnings that open at a true separation above S, per flight hour of `none`.

    Garwood's exact Poisson interval, widened by the dispersion between flights where alerts come in clusters. `n` is
    the number of false alerts.
    """
    alerts, hours = flights.none["false_alerts"], flights.none["flown_s"] / HOUR_S
    return poisson_rate(int(np.sum(alerts)), fsum(hours.tolist()), dispersion=overdispersion(alerts, hours))


FALSE_ALERT_RATE_PH = Metric(
    "warnings that open outside the zone, per flight hour", "1/h", false_alert_rate, sensor=True
)
