"""Rules of avoidance: one file each, pure kernels on relative positions and velocities."""

from rss_gym.avoidance.literal import WayPoints, flown, literal
from rss_gym.avoidance.smooth import Separation, Trajectory, separation, smooth

__all__ = ["Separation", "Trajectory", "WayPoints", "flown", "literal", "separation", "smooth"]
