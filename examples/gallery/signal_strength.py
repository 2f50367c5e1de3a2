"""
Signal strength over distance
=============================

Received signal strength (RSS) falls with the logarithm of the distance. Two kinds of noise lie on it: white
noise, which is new in each sample, and coloured noise, which changes slowly. ``paper`` and ``outdoor`` are
two radios of the package.
"""

import matplotlib.pyplot as plt
import numpy as np

from rss_gym.pages import colours, figure
from rss_gym.params import load_channel
from rss_gym.radio import received, simulate

plt.rcParams.update(figure.light())
BLUE, ORANGE = colours.light()["c0"], colours.light()["c1"]

# %%
# Two minutes of a walk from 10 m to 120 m and back, ten samples a second. The line is the path loss without
# noise.

distance_m = 65.0 - 55.0 * np.cos(np.linspace(0.0, 2.0 * np.pi, 1200))
figure_, axes = plt.subplots(1, 2, figsize=(8.6, 3.6), sharey=True)
for panel, name in zip(axes, ("paper", "outdoor"), strict=True):
    channel = load_channel(name)
    log = simulate(distance_m, 0.1, channel, seed=0)
    line_m = np.linspace(10.0, 120.0, 200)
    panel.plot(log.distance_m, log.rss_dbm, ".", color=BLUE, markersize=3, alpha=0.4, label="samples")
    panel.plot(line_m, received(line_m, channel), color=ORANGE, linewidth=2, label="path loss alone")
    panel.set(title=f"radio {name}", xlabel="distance, m")
axes[0].set_ylabel("RSS, dBm")
axes[1].legend()
plt.show()

# %%
# The noise alone, for 20 s: the sum of both kinds, and the coloured part in it. In ``outdoor`` the coloured
# noise keeps its sign for seconds, so that a mean over some samples does not remove it. An estimator has to
# follow it.

figure_, axes = plt.subplots(2, 1, figsize=(8.6, 4.6), sharex=True, sharey=True)
for panel, name in zip(axes, ("paper", "outdoor"), strict=True):
    channel = load_channel(name)
    log = simulate(distance_m, 0.1, channel, seed=0)
    part = slice(0, 200)
    noise_db = log.rss_dbm - received(log.distance_m, channel)
    panel.plot(log.time_s[part], noise_db[part], ".", color=BLUE, markersize=4, alpha=0.6, label="both")
    panel.plot(log.time_s[part], log.coloured_db[part], color=ORANGE, label="coloured")
    panel.set(title=f"radio {name}", ylabel="noise, dB")
axes[1].set_xlabel("time, s")
axes[0].legend(ncols=2)
plt.show()
