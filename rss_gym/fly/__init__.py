"""The page on which a person flies the agent's part of an encounter, beside a shipped agent on the same encounter.

The page holds the world itself: `world` translates the kernels `reset` and `step`, and the network's forward pass, to
JavaScript (`rss_gym.javascript`), `encounters` chooses what is flown, `page` puts the page together, and `equality`
flies the translated world beside Python's and compares every score.
"""

from rss_gym.fly.page import build

__all__ = ["build"]
