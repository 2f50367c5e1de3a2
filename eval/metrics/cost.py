"""The paper's own cost."""

from rss_gym.eval.intervals import Interval, mean_t
from rss_gym.eval.metrics.metric import ONE, Flights, Metric


def cost_mean(flights: Flights) -> Interval:
    """Mean over encounters of (42) summed over the decisions flown: q |u - u^d| + kappa |dv|.

    q in 1/m and kappa in s/m are those of the reward. A flight that ends early sums less: read it beside
    `collision_rate`. Student's t.
    """
    return mean_t(flights.table["cost"])


COST_MEAN = Metric("cost (42) summed over an encounter, mean", ONE, cost_mean)
