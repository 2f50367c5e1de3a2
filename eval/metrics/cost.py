"""What encounters cost: the score that policies are ranked by."""

from rss_gym.eval.costs import Costs
from rss_gym.eval.intervals import Interval
from rss_gym.eval.metrics.metric import Flights, Metric


def cost(flights: Flights) -> Interval:
    """Mean over encounters of mean deviation while flown + 100 m if sNMAC + 10,000 m if collision, in m.

    One collision in 10,000 encounters weighs as one metre of mean deviation. The interval joins Student's of the
    deviation and Clopper and Pearson's of the events (`rss_gym.eval.costs`), so it covers where collisions are rare.
    """
    return Costs.of(flights.table, flights.prices).interval()


COST_M = Metric(
    "cost of an encounter, mean: mean deviation while flown + 100 m if sNMAC + 10,000 m if collision",
    "m",
    cost,
)
