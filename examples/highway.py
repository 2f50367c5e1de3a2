"""The same sensor on the road: wrap an environment of highway-env, drive a rule, read the named fields.

Needs the extra `highway`: pip install -e '.[highway]' in the clone. Runs in seconds.
"""

import gymnasium as gym
import highway_env  # noqa: F401  registers its ids

import rss_gym  # noqa: F401  registers ours
from rss_gym.baselines import make
from rss_gym.highway import RssRanging
from rss_gym.highway.observation import split
from rss_gym.highway.params import actions


def main() -> None:
    """Wrap a road of highway-env in one line, then drive a registered one by the rule."""
    wrapped = RssRanging(gym.make("roundabout-v1"), vehicles=3)
    observation, _ = wrapped.reset(seed=0)
    seen = split(observation, wrapped.params)
    print("roundabout, estimated ranges:", ", ".join(f"{r:.0f} m" for r in seen["range_m"][seen["present"] > 0.5]))

    env = gym.make("rss_gym/Highway-v0", zone={"reaction_s": 1.0})
    observation, info = env.reset(seed=0)
    policy = make("rule", env.unwrapped.params)
    done, time_s = False, 0
    while not done:
        action, _ = policy.predict(observation)
        observation, _, terminated, truncated, info = env.step(action)
        done, time_s = terminated or truncated, time_s + 1
        seen = split(observation, env.unwrapped.params)
        nearest = f"{seen['range_m'][0]:.1f} ± {seen['range_std_m'][0]:.1f} m"
        print(f"{time_s:2d} s: {actions(policy.params)[action].lower():10}  nearest vehicle {nearest}")
    print("collision" if info["collision"] else f"no collision, {info['deviation_m']:.0f} m from the plan")


if __name__ == "__main__":
    main()
