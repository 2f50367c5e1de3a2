"""Position from ranges to reference nodes, (1): the world's kernel, the general fix, and what fewer nodes can tell."""

from rss_gym.positioning.fix import Fix, fix
from rss_gym.positioning.partial import Locus, partial

__all__ = ["Fix", "Locus", "fix", "partial"]
