"""Steps a second on the roads, and our share of their time: python benchmarks/highway.py [--seconds S]

CPU time of this process; the share is what the radio, the filter and the observation take of a step of highway-env. The
last number says how many times as many decisions a training makes in this time, where its traffic is compiled.
"""

import argparse
from time import process_time

from rss_gym.highway import sensor, wrapper
from rss_gym.highway.env import SCENES, RoadEnv

TARGET = 0.05  # share of a step


class Clock:
    """Seconds spent in functions that it stands round."""

    def __init__(self):
        self.spent_s = 0.0

    def around(self, function):
        """The function, timed."""

        def timed(*arguments):
            begin = process_time()
            try:
                return function(*arguments)
            finally:
                self.spent_s += process_time() - begin

        return timed


def measure(scene, seconds, clock, is_training=False):
    """Decisions, seconds of them without resets, and our seconds in them, of `none` on a road."""
    env = RoadEnv(scene)
    env.is_training = is_training
    idle = 1
    env.reset(seed=0)
    env.step(idle)  # compiled by now
    env.reset()
    decisions, total_s, ours_s = 0, 0.0, 0.0
    while total_s < seconds:
        begin, before = process_time(), clock.spent_s
        _, _, terminated, truncated, _ = env.step(idle)
        total_s += process_time() - begin
        ours_s += clock.spent_s - before
        decisions += 1
        if terminated or truncated:
            env.reset()
    return decisions, total_s, ours_s


def main():
    """Print a line a road."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="CPU seconds of each road")
    options = parser.parse_args()
    clock = Clock()
    sensor.Sensor.tick, sensor.Sensor.advance_slow_noise = (
        clock.around(sensor.Sensor.tick),
        clock.around(sensor.Sensor.advance_slow_noise),
    )
    wrapper.RssRanging._observe = clock.around(wrapper.RssRanging._observe)
    wrapper.RssRanging._info = clock.around(wrapper.RssRanging._info)
    for scene in SCENES:
        decisions, total_s, ours_s = measure(scene, options.seconds, clock)
        share = ours_s / total_s
        trained, training_s, _ = measure(scene, options.seconds, clock, is_training=True)
        times = trained / training_s / (decisions / total_s)
        met = "met" if share < TARGET else "missed"
        print(
            f"{scene:<13} {decisions / total_s:6.1f} decisions/s   ours {share:6.2%} (target {TARGET:.0%}: {met})   "
            f"trainings {times:.1f} times as fast",
            flush=True,
        )


if __name__ == "__main__":
    main()
