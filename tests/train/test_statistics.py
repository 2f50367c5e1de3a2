"""Models trained under VecNormalize: their statistics are applied, asked for, or the model is refused."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="stable-baselines3 (extra `train`) is not installed")

from stable_baselines3 import A2C, PPO, SAC
from stable_baselines3.common.vec_env import VecNormalize

from rss_gym import baselines
from rss_gym.cli import main
from rss_gym.eval import evaluate
from rss_gym.params import ParamsError
from rss_gym.sb3 import make_vec_env

ID = "rss_gym/Encounter-v0"
KINDS = {"ppo": PPO, "a2c": A2C, "sac": SAC}


def trained(kind, normalised=True):
    venv = VecNormalize(make_vec_env(ID, 8, seed=0), norm_obs=normalised)
    options = {"learning_starts": 10} if kind is SAC else {"n_steps": 8}
    return kind("MlpPolicy", venv, policy_kwargs={"net_arch": [8]}, device="cpu", seed=0, **options).learn(64)


def test_a_model_with_its_environment_flies_as_it_was_trained():
    model = trained(PPO)

    class ByHand:
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return model.predict(model.get_vec_normalize_env().normalize_obs(observation), deterministic=deterministic)

    one = evaluate({"model": model, "by hand": ByHand()}, episodes=20, progress=False)
    assert one["model"]["cost_m"] == one["by hand"]["cost_m"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_model_without_its_statistics_is_refused(tmp_path, kind):
    trained(KINDS[kind]).save(tmp_path / "model.zip")
    with pytest.raises(ParamsError, match="VecNormalize"):
        evaluate(KINDS[kind].load(tmp_path / "model.zip", device="cpu"), episodes=2, progress=False)


@pytest.mark.parametrize("kind", KINDS)
def test_a_model_of_plain_observations_is_not(tmp_path, kind):
    model = trained(KINDS[kind], normalised=False)
    model.save(tmp_path / "model.zip")
    loaded = KINDS[kind].load(tmp_path / "model.zip", device="cpu")
    found = evaluate({"one": model, "two": loaded}, episodes=5, progress=False)
    assert found["one"]["cost_m"] == found["two"]["cost_m"]


@pytest.mark.parametrize("kind", ["ppo", "sac"])
def test_export_asks_for_the_statistics_and_applies_them(tmp_path, capsys, kind):
    model = trained(KINDS[kind])
    model.save(tmp_path / "model.zip")
    model.get_vec_normalize_env().save(tmp_path / "statistics.pkl")
    export = ["export", str(tmp_path / "model.zip"), "--out", str(tmp_path / "agent")]
    assert main(export) == 2 and "--statistics" in capsys.readouterr().err and not (tmp_path / "agent").exists()
    assert main([*export, "--statistics", str(tmp_path / "statistics.pkl")]) == 0
    agent = baselines.make(str(tmp_path / "agent"))
    venv = make_vec_env(ID, 8, seed=5)
    plain = venv.reset()
    wanted, _ = model.predict(model.get_vec_normalize_env().normalize_obs(plain), deterministic=True)
    np.testing.assert_allclose(agent.predict(plain)[0], np.clip(wanted, -1, 1), atol=1e-5)


def test_wrong_statistics_are_named(tmp_path, capsys):
    trained(PPO).save(tmp_path / "model.zip")
    other = VecNormalize(make_vec_env("rss_gym/Encounter3D-v0", 2))
    other.save(tmp_path / "other.pkl")
    (tmp_path / "garbage.pkl").write_bytes(b"garbage")
    for name, words in (("other.pkl", "shape"), ("garbage.pkl", "cannot be read"), ("missing.pkl", "cannot be read")):
        given = ["export", str(tmp_path / "model.zip"), "--out", str(tmp_path / "agent")]
        assert main([*given, "--statistics", str(tmp_path / name)]) == 2
        err = capsys.readouterr().err
        assert words in err and name in err
