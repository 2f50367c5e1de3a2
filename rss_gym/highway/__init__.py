"""The radio, the filter and the safety zone of rss_gym on the roads of highway-env (extra `highway`).

`RssRanging` wraps any environment of highway-env; `rss_gym/Highway-v0`, `Merge-v0` and `Intersection-v0` are made of
it.
"""

from rss_gym.highway.wrapper import RssRanging

__all__ = ["RssRanging"]
