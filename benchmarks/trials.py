"""Trials of independent looks, counted one by one, beside NumPy's generator drawing the same number of looks.

Run it as python benchmarks/trials.py
"""

import time

import numpy as np

from rss_gym.safety.counting import count_missed

TRIALS, LOOKS, PROBABILITY, AIM_S = 100_000_000, 16, 0.8, 60.0
BLOCK = 10_000_000


def main() -> None:
    """Print the rate, its ratio to NumPy's, and whether 1e8 trials stay within a minute."""
    count_missed(PROBABILITY, LOOKS, 1000)  # compiles
    start = time.process_time()
    missed = count_missed(PROBABILITY, LOOKS, TRIALS)
    ours_s = time.process_time() - start
    looks = int(missed[:-1].sum())  # a trial with n wrong looks has taken n + 1
    random = np.random.default_rng(0)
    start = time.process_time()
    for _ in range(looks // BLOCK):
        np.count_nonzero(random.random(BLOCK) > PROBABILITY)
    numpy_s = (time.process_time() - start) * looks / (looks // BLOCK * BLOCK)
    rate = TRIALS / ours_s / 1e6
    print(f"{TRIALS:.0e} trials, {looks:,} looks: {ours_s:.2f} CPU s, {rate:.1f} million trials a second")
    print(f"NumPy, as many looks: {numpy_s:.2f} CPU s, ratio {numpy_s / ours_s:.2f}")
    print(f"within {AIM_S:g} s: {'yes' if ours_s <= AIM_S else 'NO'}")


if __name__ == "__main__":
    main()
