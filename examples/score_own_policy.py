"""Score a policy of your own on the encounters of the rules: python examples/score_own_policy.py [--episodes N].

From this folder the command does the same: rss-gym eval --policy score_own_policy:PassBehind --out runs/own
"""

import argparse
from typing import Any

import numpy as np

from rss_gym import observation
from rss_gym.eval import evaluate, text
from rss_gym.params import Params


class PassBehind:
    """Flies to the side that the intruder comes from while the track predicts a near miss, and back to its path after.

    It shows how a policy is written, and costs more than the rules. All that the evaluator asks for is `predict`, as
    Stable-Baselines3 has it, on batches.

    Parameters
    ----------
    params : Params
        Tells what the columns of an observation are.
    """

    def __init__(self, params: Params) -> None:
        self.params = params

    def predict(
        self, rows: np.ndarray, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[np.ndarray, Any]:
        """Actions (n, 2) in [-1, 1] for observations (n, d); this policy has no memory, so `state` stays as it is."""
        seen = observation.split(rows, self.params)
        near = (seen["track_valid"][:, 0] > 0.5) & (seen["planned_distance_m"][:, 0] < 30.0)
        near &= (seen["range_m"][:, 0] < 90.0) & (seen["planned_time_s"][:, 0] > 0.0)
        # An action is a change of velocity in shares of the speed limit; zero would keep the present offset.
        back = -0.05 * np.stack([seen["way_point_along_m"], seen["way_point_right_m"]], axis=1)
        actions = np.clip(back, -0.3, 0.3).astype(np.float32)
        # It flies to the right: the space behind it is on the left, and the other way round.
        side = -np.sign(seen["message_velocity_right_mps"][:, 0])
        actions[near] = np.stack([np.zeros(len(rows)), 0.5 * side], axis=1)[near]
        return actions, state


def main() -> None:
    """Fly it beside the paper's rule; `none` is always flown too."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=5000)
    options = parser.parse_args()
    policies = {"pass-behind": PassBehind(Params()), "orthogonal": "orthogonal:radius_m=60"}
    print(text.table(evaluate(policies, episodes=options.episodes)))


if __name__ == "__main__":
    main()
