"""Makes the README's picture: `python docs/make.py`."""

from pathlib import Path

import gymnasium as gym
from PIL import Image

from rss_gym import baselines

ROOT = Path(__file__).resolve().parent.parent
SHOWN_SEED, SHOWN_S = 19, 29.0


def main() -> None:
    """One frame of the rule in flight."""
    policy = baselines.make("orthogonal:radius_m=60")
    env = gym.make("rss_gym/Encounter-v0", render_mode="rgb_array")
    observation, _ = env.reset(seed=SHOWN_SEED)
    state = None
    for _ in range(int(SHOWN_S / policy.world.clock.decision_s)):
        action, state = policy.predict(observation, state)
        observation, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            break
    Image.fromarray(env.render()).save(ROOT / "docs" / "encounter.png", optimize=True)


if __name__ == "__main__":
    main()
