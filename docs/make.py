"""Makes the README's picture and the training that it quotes, and the list in docs/agents.md: `python docs/make.py`."""

from pathlib import Path

import gymnasium as gym
from opponents import put, table
from PIL import Image

from rss_gym import baselines
from rss_gym.baselines import shipped
from rss_gym.train.ship import CARD

ROOT = Path(__file__).resolve().parent.parent
SHOWN_SEED, SHOWN_S = 19, 29.0


def agents() -> str:
    """Those that are shipped, in Markdown."""
    rows = [
        [
            f"[`{name}`](../{folder.resolve().relative_to(ROOT).as_posix()}/{CARD})",
            f"`{shipped.home(name)}`",
            shipped.summary(folder),
        ]
        for name, folder in baselines.AGENTS.items()
    ]
    return table(["agent and card", "trained in", "how"], rows) if rows else "This version comes without an agent."


def main() -> None:
    """The example without its first line, the agents, and one frame of the rule in flight."""
    _, _, code = (ROOT / "examples" / "sb3_ppo.py").read_text(encoding="utf-8").partition('"""\n\n')
    put(ROOT / "README.md", "sb3", f"```python\n{code}```")
    put(ROOT / "docs" / "agents.md", "agents", agents())
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
