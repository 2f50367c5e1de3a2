"""
The range of one encounter beside the truth
===========================================

In an encounter the agent knows the distance of the other aircraft by the filter only. The band is one
standard deviation, as the filter states it.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from rss_gym import baselines
from rss_gym.pages import colours, figure
from rss_gym.render.film import fly

plt.rcParams.update(figure.light())
POLICY, SEED = "orthogonal:radius_m=40", 29

# %%
# ``fly`` flies one encounter to its end and keeps a scene for each decision: the true positions, and what the
# radio says.

env = gym.make("rss_gym/Encounter-v0")
flight = fly(env, baselines.make(POLICY), POLICY, SEED)
time_s = np.array([scene.time_s for scene in flight.scenes])
truth_m = np.array([np.linalg.norm(s.intruders[0].position_m - s.own.position_m) for s in flight.scenes])
range_m = np.array([scene.intruders[0].range_m for scene in flight.scenes])
std_m = np.array([scene.intruders[0].range_std_m for scene in flight.scenes])
print(f"{flight.name}: {flight.outcome}; least distance {truth_m.min():.1f} m")

# %%
# Near the closest approach the estimate is at its best, because the same error in decibels is a share of the
# distance.

figure_, axes = plt.subplots(2, 1, figsize=(8.6, 5.2), sharex=True, height_ratios=(2, 1))
blue, ink = colours.light()["ring"], colours.light()["ink"]
axes[0].fill_between(time_s, range_m - std_m, range_m + std_m, color=blue, alpha=0.25, linewidth=0)
axes[0].plot(time_s, range_m, color=blue, label="range by the filter")
axes[0].plot(time_s, truth_m, color=ink, label="truth")
axes[0].set(ylabel="distance, m", ylim=(0.0, None))
axes[0].legend(ncols=2)
axes[1].fill_between(time_s, -std_m, std_m, color=blue, alpha=0.25, linewidth=0)
axes[1].plot(time_s, range_m - truth_m, color=blue)
axes[1].set(xlabel="time, s", ylabel="error, m")
plt.show()
