"""
Estimators side by side
=======================

Five estimators of range run over the same record. Least squares turns each sample into a distance. The others
are extended Kalman filters (EKF): the white ones take all noise to be white, and the coloured one estimates
the coloured noise as well.
"""

import matplotlib.pyplot as plt
import numpy as np

from rss_gym.pages import colours, figure
from rss_gym.params import load_channel
from rss_gym.radio import simulate
from rss_gym.ranging import ESTIMATORS, track

plt.rcParams.update(figure.light())
NAMES = ("ls", "ls-window", "ekf-white-r", "ekf-white", "ekf-coloured")

# %%
# Ten minutes of an aircraft that comes and goes between 10 m and 100 m at 5 m/s, with the radio of the paper.

channel = load_channel("paper")
time_s = np.arange(0.0, 600.0, 0.1)
distance_m = 10.0 + 90.0 * np.abs((5.0 * time_s / 90.0) % 2.0 - 1.0)
log = simulate(distance_m, 0.1, channel, seed=0)
ranges_m = {name: track(name, log.time_s, log.rss_dbm, channel).range_m for name in NAMES}

# %%
# How many of the errors are below a limit: the curve further to the left is the better one.

figure_, axes = plt.subplots(figsize=(8.6, 3.8))
share = np.linspace(0.0, 0.98, 200)
for name in NAMES:
    error_m = np.abs(ranges_m[name] - log.distance_m)
    shade, title = colours.of_estimator(name), ESTIMATORS[name].title
    axes.plot(np.quantile(error_m, share), 100.0 * share, color=shade, label=title)
    print(f"{title}: 80 % of the errors are within {np.quantile(error_m, 0.8):.1f} m")
axes.axhline(80.0, color=colours.light()["muted"], linewidth=0.8, linestyle=":")
axes.set(xlabel="absolute range error, m", ylabel="share of samples, %")
axes.set(xlim=(0.0, 40.0), ylim=(0.0, 100.0))
axes.legend(loc="lower right")
plt.show()

# %%
# Half a minute of the same record: what the estimators say beside the true distance.

figure_, axes = plt.subplots(figsize=(8.6, 3.8))
part = slice(2000, 2300)
seconds = log.time_s[part]
axes.plot(seconds, log.distance_m[part], color=colours.light()["ink"], linewidth=2, label="truth")
for name, style in (("ls", "."), ("ekf-white-r", "-"), ("ekf-coloured", "-")):
    shade, title = colours.of_estimator(name), ESTIMATORS[name].title
    axes.plot(seconds, ranges_m[name][part], style, color=shade, markersize=3, label=title)
axes.set(xlabel="time, s", ylabel="distance, m")
axes.legend(ncols=4)
plt.show()
