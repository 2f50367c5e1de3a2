"""
One encounter, flown by the rule and by a learned agent
=======================================================

Both fly the same encounter with the same noise. The rule of the paper moves aside across the intruder's
course; the agent ``pathwise-plane``, which comes with the package, has learned its manoeuvre.
"""

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np

from rss_gym import baselines
from rss_gym.pages import colours, figure
from rss_gym.render.film import fly

plt.rcParams.update(figure.light())
POLICIES, SEED = ("orthogonal:radius_m=40", "pathwise-plane"), 29

# %%
# The true paths, with a dot every ten seconds.

env = gym.make("rss_gym/Encounter-v0")
flights = [fly(env, baselines.make(policy), policy, SEED) for policy in POLICIES]
colour = colours.light()
figure_, axes = plt.subplots(figsize=(8.6, 6.4))


def draw(path_m, shade, label):
    """A path with a dot every ten seconds."""
    axes.plot(path_m[:, 0], path_m[:, 1], color=shade, label=label)
    axes.plot(path_m[::20, 0], path_m[::20, 1], ".", color=shade, markersize=7)


planned_m = np.array([scene.planned_m for scene in flights[0].scenes])
other_m = np.array([scene.intruders[0].position_m for scene in flights[0].scenes])
axes.plot(planned_m[:, 0], planned_m[:, 1], "--", color=colour["muted"], label="planned path")
draw(other_m, colour["orange"], "intruder")
for flight in flights:
    own_m = np.array([scene.own.position_m for scene in flight.scenes])
    draw(own_m, colours.of_policy(flight.name), f"{flight.name}: {flight.outcome}")
    nearest = np.argmin(np.linalg.norm(own_m - other_m, axis=1))
    pair_m = np.stack([own_m[nearest], other_m[nearest]])
    axes.plot(pair_m[:, 0], pair_m[:, 1], ":", color=colour["red"])
axes.plot([], [], ":", color=colour["red"], label="where they are nearest")
axes.set(xlabel="east, m", ylabel="north, m", aspect="equal")
axes.legend(loc="center left", bbox_to_anchor=(1.05, 0.5))
plt.show()

# %%
# The distance between the two aircraft, and how far each policy goes from the planned path.

figure_, axes = plt.subplots(2, 1, figsize=(8.6, 4.8), sharex=True)
for flight in flights:
    shade = colours.of_policy(flight.name)
    time_s = [scene.time_s for scene in flight.scenes]
    apart_m = [np.linalg.norm(s.own.position_m - s.intruders[0].position_m) for s in flight.scenes]
    aside_m = [np.linalg.norm(scene.own.position_m - scene.planned_m) for scene in flight.scenes]
    axes[0].plot(time_s, apart_m, color=shade, label=flight.name)
    axes[1].plot(time_s, aside_m, color=shade, label=flight.name)
axes[0].set(ylabel="separation, m", ylim=(0.0, None))
axes[1].set(xlabel="time, s", ylabel="distance from the path, m", ylim=(0.0, None))
axes[0].legend(ncols=2)
plt.show()
