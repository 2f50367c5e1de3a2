"""
Safety against deviation
========================

A policy that goes far out of its way meets nobody. What counts is how few near collisions it has at how
little deviation. All policies fly the same encounters with the same noise.
"""

import matplotlib.pyplot as plt

from rss_gym.eval import evaluate, text
from rss_gym.pages import colours, figure

plt.rcParams.update(figure.light())
CURVES = {"orthogonal": (30, 40, 60), "orca": (15, 20, 25)}  # m
ALONE = ("mpc", "pathwise-plane", "ppo-plane")

# %%
# Five hundred encounters are too few to tell near policies apart, but their order of magnitude is to be seen.

curves = {rule: [f"{rule}:radius_m={radius}" for radius in radii] for rule, radii in CURVES.items()}
curves |= {policy: [policy] for policy in ALONE}
result = evaluate([spec for specs in curves.values() for spec in specs], episodes=500, progress=False)
print(text.table(result))

# %%
# The best is at the lower left. Bars are 95 % intervals; a hollow point had no near collision (sNMAC, below
# 15.24 m) and stands at the upper end of its interval.

figure_, axes = plt.subplots(figsize=(8.6, 4.6))
for name, specs in curves.items():
    shade = colours.of_policy(name)
    rates = [result[spec]["snmac_rate"] for spec in specs]
    deviation_m = [result[spec]["path_deviation_mean_m"].value for spec in specs]
    height = [100.0 * (rate.value or rate.high) for rate in rates]
    down = [h - 100.0 * (rate.low or rate.high) for h, rate in zip(height, rates, strict=True)]
    up = [100.0 * rate.high - h for h, rate in zip(height, rates, strict=True)]
    axes.errorbar(deviation_m, height, (down, up), color=shade, elinewidth=0.8, label=name)
    for x, y, rate in zip(deviation_m, height, rates, strict=True):
        axes.plot(x, y, "o", color=shade, fillstyle="full" if rate.value else "none")
axes.set(xlabel="mean deviation, m", ylabel="near collisions, % of encounters", yscale="log")
axes.legend(ncols=3, title="best: lower left")
plt.show()
