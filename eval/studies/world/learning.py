"""Does standard RL learn here? PPO of Stable-Baselines3 with the settings of `examples/sb3_ppo.py`, from scratch."""

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from rss_gym.eval.columns import AIR
from rss_gym.eval.evaluate import evaluate
from rss_gym.eval.studies.section import Criterion, Scale, Section
from rss_gym.eval.studies.world.rows import ORCA, OTHERS, RULE, SEED, Scores, cells, cheapest, fly, value

EPISODES = 10_000
METRICS = ("cost_m", "collision_rate", "path_deviation_mean_m")
# Only being near is priced: collisions are too rare to learn from, and their price is mostly noise.
WORLD: dict[str, Any] = {
    "collision_price_m": 0.0,
    "snmac_price_m": 0.0,
    "proximity_price_m": 4000.0,
    "comfort_m": 25.0,
}
OPTIONS: dict[str, Any] = {"n_steps": 32, "batch_size": 2048, "n_epochs": 8, "gamma": 0.95, "ent_coef": 0.003}
LEARNING_RATE, ROWS = 3e-3, 256


def section(scale: Scale) -> Section:
    """Scores after every third of each training, beside the rule and `orca` at their cheapest."""
    with ProcessPoolExecutor(scale.workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        runs = list(pool.map(trained, range(scale.seeds), [scale.decisions] * scale.seeds))
    rows = [
        [f"PPO, seed {seed}", f"{decisions:,}", f"{cpu_s:.0f}", *cells(scores, METRICS)]
        for seed, run in enumerate(runs)
        for decisions, cpu_s, scores in run
    ]
    found = fly(ORCA + OTHERS + RULE, scale, episodes=EPISODES)
    best, rule = (cheapest({name: found[name] for name in names}) for names in (found, RULE))
    rows += [[name, "", "", *cells(found[name], METRICS)] for name in (best, rule)]
    last = [value(run[-1][2], "cost_m") for run in runs]
    costs = ", ".join(f"{cost:.1f}" for cost in last)
    return Section(
        "Standard RL learns",
        f"`examples/sb3_ppo.py` trains for {scale.decisions:,} decisions with each seed, on one core; the seconds "
        f"are processor time of that process. Each row is scored with deterministic actions on {EPISODES:,} "
        f"encounters, seed {SEED}.",
        ("policy", "decisions", "CPU s", *(AIR[metric].heading for metric in METRICS)),
        rows,
        [
            Criterion(
                f"every seed ends cheaper than the {name} (`{policy}`){aim}",
                f"{costs} m against {value(found[policy], 'cost_m'):.1f} m",
                max(last) < value(found[policy], "cost_m"),
            )
            for name, policy, aim in (("rule", rule, ""), ("best scripted policy", best, " (aim)"))
        ],
    )


def trained(seed: int, decisions: int) -> list[tuple[int, float, Scores]]:
    """One training: after each third of it the decisions, the CPU seconds spent learning, and the scores."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from rss_gym.sb3 import make_vec_env

    torch.set_num_threads(1)
    rows = make_vec_env("rss_gym/Encounter-v0", n_envs=ROWS, seed=seed, **WORLD)
    env = VecNormalize(rows, norm_obs=False, gamma=OPTIONS["gamma"])

    def rate(_: float) -> float:
        """Falls over the whole training, which SB3 does not know of in the thirds."""
        return LEARNING_RATE * (1.0 - model.num_timesteps / decisions)

    model = PPO("MlpPolicy", env, learning_rate=LEARNING_RATE, seed=seed, device="cpu", **OPTIONS)
    model.lr_schedule = rate
    found: list[tuple[int, float, Scores]] = []
    spent_s = 0.0
    for third in range(3):
        begun_s = time.process_time()
        model.learn(decisions * (third + 1) // 3 - model.num_timesteps, reset_num_timesteps=False)
        spent_s += time.process_time() - begun_s
        result = evaluate({"ppo": model}, "encounter-v0", EPISODES, SEED, progress=False)
        found.append((model.num_timesteps, spent_s, result["ppo"]))
    return found
