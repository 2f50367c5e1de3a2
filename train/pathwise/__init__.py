"""Pathwise gradients: the cost of a flight is differentiated along the flight itself.

The derivative of every step by the agent's state and action comes from the world's own kernels (`rss_gym.sensitivity`),
that of the action by the observation from the network. One backward pass through time then says for every decision
which way its action should have been changed: a few hundred flights give a gradient for which an estimate by the score
function needs millions of decisions. What a manoeuvre changes in the errors of estimates is not differentiated.
"""

from rss_gym.train.pathwise.algorithm import Pathwise

__all__ = ["Pathwise"]
