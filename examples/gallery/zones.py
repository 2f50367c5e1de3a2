"""
Safety zones over time
======================

Each intruder has a safety zone round it. A warning opens when the estimated range falls below the radius of
the zone, and closes when the range has been well outside for some seconds. While it is open, the intruder
sends messages.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from rss_gym import baselines
from rss_gym.pages import colours, figure
from rss_gym.render.film import fly

plt.rcParams.update(figure.light())
POLICY, SEED, INTRUDERS = "orca:radius_m=20", 15, 3

# %%
# Three intruders merge with the agent's path one after another. The radius of 120 m is that of the highest
# relative speed; with ``zone="adaptive"`` it would follow the relative speed of the moment.

traffic = {"families": ["merging"], "intruders": INTRUDERS, "intruders_min": INTRUDERS}
env = gym.make("rss_gym/Encounter-v0", **traffic)
flight = fly(env, baselines.make(POLICY, env.unwrapped.params), POLICY, SEED)
colour = colours.light()
time_s = np.array([scene.time_s for scene in flight.scenes])
figure_, axes = plt.subplots(INTRUDERS, 1, figsize=(8.6, 6.4), sharex=True, sharey=True)
for number, panel in enumerate(axes):
    seen = [scene.intruders[number] for scene in flight.scenes]
    truth_m = [np.linalg.norm(s.intruders[number].position_m - s.own.position_m) for s in flight.scenes]
    warning = np.array([intruder.warning for intruder in seen])
    range_m = [intruder.range_m for intruder in seen]
    radius_m = [intruder.zone_radius_m for intruder in seen]
    panel.plot(time_s, range_m, color=colour["ring"], label="range by the filter")
    panel.plot(time_s, truth_m, color=colour["ink"], label="truth")
    panel.plot(time_s, radius_m, "--", color=colour["orange"], label="radius of the zone")
    panel.fill_between(time_s, 0.0, 5.0, where=warning, color=colour["red"], step="post", label="warning")
    open_s = 0.5 * warning.sum()
    panel.set(title=f"intruder {number + 1}: warning open for {open_s:.1f} s")
    panel.set_ylabel("distance, m")
axes[0].set_ylim(0.0, 200.0)
axes[0].legend(ncols=4, loc="upper right")
axes[-1].set_xlabel("time, s")
plt.show()
