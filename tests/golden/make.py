"""Digests of whole episodes, which every machine and every build must reproduce.

`python tests/golden/make.py` freezes them in episodes.json after a change of the world; `--print` only shows them.
"""

import argparse
import hashlib
import json
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np

FILE = Path(__file__).with_name("episodes.json")
EPISODES = 3
PLANE, SPACE, RANGE_ONLY = "rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0", "rss_gym/EncounterRangeOnly-v0"
ESTIMATORS = ("ekf-coloured", "ekf-white", "ekf-white-r", "ls")
CASES = {
    **{f"{name[8:]} {kind}": (name, {"estimator": kind}) for name in (PLANE, SPACE, RANGE_ONLY) for kind in ESTIMATORS},
    "oracle": (PLANE, {"information": "oracle"}),
    "latest": (SPACE, {"tracker": "latest"}),
    "two intruders": (PLANE, {"intruders": 2}),
    "one to eight intruders": (SPACE, {"intruders": 8, "intruders_min": 1}),
    "gnss": (SPACE, {"agent": "gnss", "intruder": "gnss"}),
    "dead reckoning": (SPACE, {"agent": "dead-reckoning", "intruder": "dead-reckoning"}),
    "late and lost messages": (PLANE, {"message_latency_s": 0.6, "message_loss": 0.3, "announce_s": 8.0}),
    "shaped": (PLANE, {"shaping_m": 50.0, "proximity_price_m": 5.0}),
    "discrete": (SPACE, {"action": "discrete"}),
    "adaptive zone": (PLANE, {"zone": "adaptive"}),
    "channels": (PLANE, {"channel": ["radios", "clean"]}),
    "poor radio": (PLANE, {"channel": {"packet_loss": 0.3, "quantisation_db": 1.0, "sensitivity_dbm": -95.0}}),
    "fine clock": (PLANE, {"tick_s": 0.05, "decision_s": 0.2, "tail_min_s": 5.0, "tail_max_s": 5.0}),
    **{name: (PLANE, {"families": name}) for name in ("late-turn", "accelerating", "deceitful")},
    **{name: (PLANE, {"families": name}) for name in ("path-loss-jump", "outage")},
    "merging": (PLANE, {"families": "merging", "intruders": 8, "intruders_min": 2}),
}


def action(space, episode, step):
    """Nothing in every other episode, which may collide; else held for 16 decisions, exact but for one division."""
    held = step // 16
    if episode % 2:
        return space.sample() * 0
    if isinstance(space, gym.spaces.Discrete):
        return (3 * held + 1) % int(space.n)
    return np.array([((37 * held + 11 * axis + 5) % 41) / 20.0 - 1.0 for axis in range(space.shape[0])])


def fly(case):
    """Digest of `EPISODES` episodes in a row, and what a reader can compare when it differs."""
    name, keywords = CASES[case]
    env, seed = gym.make(f"rss_gym:{name}", **keywords).unwrapped, 7 * list(CASES).index(case)
    digest, decisions, collisions, returns = hashlib.sha256(), [], [], []
    for episode in range(EPISODES):
        observation, info = env.reset(seed=seed if episode == 0 else None)
        digest.update(observation.tobytes())
        total, step, ended = 0.0, 0, False
        while not ended:
            observation, reward, terminated, truncated, info = env.step(action(env.action_space, episode, step))
            digest.update(observation.tobytes())
            digest.update(np.array([reward, terminated, truncated, *info.values()], np.float64).tobytes())
            total, step, ended = total + reward, step + 1, terminated or truncated
        decisions.append(step)
        collisions.append(terminated)
        returns.append(total.hex())
    return {"sha256": digest.hexdigest(), "decisions": decisions, "collisions": collisions, "returns": returns}


def digests():
    """Case -> digest."""
    return {case: fly(case) for case in CASES}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--print", action="store_true", help="print them, change nothing")
    if parser.parse_args().print:
        json.dump(digests(), sys.stdout)
        return
    before = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    after = digests()
    lines = (f"{json.dumps(case)}: {json.dumps(value)}" for case, value in after.items())
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    print(f"{FILE}: {sum(before.get(case) != value for case, value in after.items())} of {len(after)} changed")


if __name__ == "__main__":
    main()
