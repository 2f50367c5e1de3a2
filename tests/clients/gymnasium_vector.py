"""A plug-in of pytest that puts this package's environments in place of those that Gymnasium's vector tests make.

The ids of Gymnasium's examples make an encounter, and `SyncVectorEnv` of encounters is the batch of this package, so
that a test that compares it with `AsyncVectorEnv` compares the batch with single environments in other processes.
"""

import warnings

import gymnasium as gym
from gymnasium import wrappers

from rss_gym.env import EncounterEnv
from rss_gym.vector import EncounterVectorEnv

SELECTED = [
    f"tests/{name}"
    for name in (
        "vector/test_vector_env.py::test_vector_env_equal",
        "vector/test_vector_env.py::test_partial_reset",
        "vector/test_vector_env.py::test_partial_reset_failure",
        "vector/test_sync_vector_env.py::test_reset_sync_vector_env",
        "vector/test_sync_vector_env.py::test_render_sync_vector",
        "vector/test_sync_vector_env.py::test_call_sync_vector_env",
        "vector/test_sync_vector_env.py::test_set_attr_sync_vector_env",
        "vector/test_async_vector_env.py::test_create_async_vector_env",
        "vector/test_async_vector_env.py::test_metadata_async_vector_env",
        "vector/test_async_vector_env.py::test_render_async_vector",
        "vector/test_async_vector_env.py::test_call_async_vector_env",
        "vector/test_async_vector_env.py::test_set_attr_async_vector_env",
        "vector/test_async_vector_env.py::test_copy_async_vector_env",
        "vector/test_async_vector_env.py::test_no_copy_async_vector_env",
        "vector/test_async_vector_env.py::test_reset_out_of_order_async_vector_env",
        "vector/test_async_vector_env.py::test_step_out_of_order_async_vector_env",
        "vector/test_async_vector_env.py::test_already_closed_async_vector_env",
        "vector/test_autoreset_mode.py::test_make_vec_autoreset",
        "vector/test_vector_wrapper.py::test_vector_env_wrapper_attributes",
        "vector/test_vector_wrapper.py::test_vector_env_metadata",
        "wrappers/vector/test_dict_info_to_list.py::test_usage_in_vector_env",
        "wrappers/vector/test_record_episode_statistics.py::test_record_episode_statistics",
        "wrappers/vector/test_vector_wrappers.py",
    )
]
SELECTED += ["-k", "not CarRacing and not RescaleObservation"]  # of pixels, and of a cart's four numbers
PLAIN = (wrappers.OrderEnforcing, wrappers.PassiveEnvChecker, wrappers.TimeLimit)
_Sync = gym.vector.SyncVectorEnv


class Encounter(EncounterEnv):
    """An encounter with the attribute that Gymnasium's tests read of a cart with a pole."""

    gravity = 9.8


class Encounters(EncounterVectorEnv):
    """The batch of them."""

    def __init__(self, num_envs=1, **keywords):
        super().__init__(num_envs, **keywords)
        self.set_attr("gravity", 9.8)


def batch(env_fns, **keywords):
    """The batch in place of a `SyncVectorEnv`, unless the environments are wrapped, or none of ours."""
    env_fns = list(env_fns)
    first = layer = env_fns[0]()
    while isinstance(layer, PLAIN):
        layer = layer.env
    if not isinstance(layer, Encounter) or set(keywords) - {"autoreset_mode"}:
        return _Sync(env_fns, **keywords)
    return Encounters(len(env_fns), render_mode=first.render_mode, **keywords)


with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # each stands in the registry
    for name in ("CartPole-v1", "MountainCarContinuous-v0"):
        gym.register(name, entry_point=Encounter, vector_entry_point=Encounters)
gym.vector.SyncVectorEnv = batch
