"""Makes the README's picture and its table of scores: python docs/make.py (a few minutes)."""

import re
from pathlib import Path

import gymnasium as gym
from PIL import Image

from rss_gym import baselines
from rss_gym.eval import evaluate
from rss_gym.eval.records import versions
from rss_gym.eval.text import cell

ROOT = Path(__file__).resolve().parent.parent
EPISODES, SEED, WORKERS = 100_000, 0, 2
SHOWN_SEED, SHOWN_S = 5, 37.0
POLICIES = [
    "none",
    *(f"orthogonal:radius_m={radius}" for radius in (20, 40, 60, 80, 120)),
    "orthogonal@oracle:radius_m=60",
    "constant:right_m=30",
    "blind",
    "brake",
    "right-turn",
    "random",
]
COLUMNS = {
    "collision_rate": ("collisions", ".2e"),
    "snmac_rate": ("sNMACs", ".2e"),
    "risk_ratio": ("risk ratio", ".3f"),
    "path_deviation_mean_m": ("mean deviation, m", ".1f"),
    "unnecessary_manoeuvre_rate": ("unnecessary manoeuvres", ".3f"),
}


def picture() -> None:
    """One frame of the rule in flight."""
    policy = baselines.make("orthogonal:radius_m=60")
    env = gym.make("rss_gym/Encounter-v0", params=policy.world, render_mode="rgb_array")
    observation, _ = env.reset(seed=SHOWN_SEED)
    state = None
    for _ in range(int(SHOWN_S / policy.world.clock.decision_s)):
        action, state = policy.predict(observation, state)
        observation, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            break
    Image.fromarray(env.render()).save(ROOT / "docs" / "encounter.png", optimize=True)


def scores() -> str:
    """The table as Markdown."""
    result = evaluate(POLICIES, episodes=EPISODES, seed=SEED, workers=WORKERS)
    lines = [
        "| policy | " + " | ".join(title for title, _ in COLUMNS.values()) + " |",
        "|---|" + "---|" * len(COLUMNS),
    ]
    for scored in result.policies:
        cells = [cell(scored.metrics[name], 1.0, form) for name, (_, form) in COLUMNS.items()]
        lines.append(f"| `{scored.entry.name}` | " + " | ".join(cells) + " |")
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    lines.append("")
    lines.append(
        f"{EPISODES} encounters of suite `{result.suite.name}`, split `{result.suite.split}`, seed {SEED}; 95 % "
        f"intervals in brackets; made by `python docs/make.py` with {used}."
    )
    return "\n".join(lines)


def main() -> None:
    """Write the picture, and the table between its markers."""
    picture()
    path = ROOT / "README.md"
    marked = r"(<!-- scores -->\n).*?(\n<!-- /scores -->)"
    text = re.sub(marked, lambda found: found[1] + scores() + found[2], path.read_text(), flags=re.DOTALL)
    path.write_text(text)


if __name__ == "__main__":
    main()
