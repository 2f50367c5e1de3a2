"""Pictures of an encounter, drawn into RGB arrays without a display.

`draw` knows nothing of the simulator: it takes a `Scene` of plain numbers. `rss_gym.render.recorder` makes scenes of
the rows of a batch, `rss_gym.render.window` shows frames on the screen, `rss_gym.render.painter` is what the
environments hold. Pillow and pygame are imported when something is drawn or shown, not when these modules are.
"""

from rss_gym.render.frame import draw, map_view
from rss_gym.render.map import View
from rss_gym.render.scene import Aircraft, Intruder, Scene

__all__ = ["Aircraft", "Intruder", "Scene", "View", "draw", "map_view"]
