"""Small trainings for the tests."""

import pytest

SMALL = {
    "recipe.steps": 4096,
    "vec.n_envs": 64,
    "algorithm.n_steps": 16,
    "algorithm.batch_size": 256,
    "algorithm.n_epochs": 2,
    "policy.net_arch": [8],
    "imitation.episodes": 0,
    "validation.every_steps": 2048,
    "validation.episodes": 40,
    "checkpoint.every_steps": 1024,
}


@pytest.fixture(scope="session")
def small():
    """Changes of the recipe `ppo` that make it a matter of a second."""
    return dict(SMALL)
