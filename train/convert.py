"""`rss-gym export`: the best policy of a run, or a model of Stable-Baselines3, as a policy folder."""

from __future__ import annotations

import importlib
import json
import os
import pickle
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rss_gym.baselines.agent import load
from rss_gym.baselines.masks import MASKS
from rss_gym.domain import domain_of, domain_of_id
from rss_gym.eval.normalised import saw_normalised
from rss_gym.files import check_new, new_folder
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params, ParamsError, suggestion
from rss_gym.train.export import Inputs, Normalisation, export
from rss_gym.train.hyperparameters import ALGORITHMS
from rss_gym.train.run import AGENT, best_seed, read, training_record
from rss_gym.train.run_record import copy_policy

DATA_MAX = 1 << 26  # bytes


def export_run(run: str | os.PathLike[str], out: str | os.PathLike[str]) -> float:
    """Write the best policy of a run into the new folder `out`; of a run that goes on, the best so far.

    Returns
    -------
    float
        Greatest difference from SB3's actions, measured when the policy was kept.

    Raises
    ------
    ParamsError
        If this is not the folder of a run, or it has no policy yet.
    """
    recipe, _ = read(run)
    check_new(out)
    agent = Path(run) / AGENT
    source = agent if agent.is_dir() else best_seed(run)[0]
    with new_folder(out) as folder:
        copy_policy(source, folder)
        return float(training_record(load(folder, recipe.params), "difference"))


def export_model(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    env: str = "rss_gym/Encounter-v0",
    algorithm: str | None = None,
    world: Mapping[str, Any] | None = None,
    zeroed: str = "nothing",
    statistics: str | os.PathLike[str] | None = None,
) -> float:
    """Read a `.zip` of SB3, which runs code from it, and write the policy into the new folder `out`.

    Parameters
    ----------
    path : path
        What SB3's `save` wrote.
    out : path
        New folder.
    env : str
        The id it was trained in.
    algorithm : str, optional
        One of `ALGORITHMS`; default: what the file looks like.
    world : mapping, optional
        Parameters that differed from those of the id.
    zeroed : str
        What it was trained without, one of `rss_gym.baselines.masks.MASKS`; the file does not tell.
    statistics : path, optional
        What `VecNormalize.save` wrote, which runs code too when it is read; needed for a model that was trained on
        normalised observations.

    Returns
    -------
    float
        Greatest difference from SB3's actions on 1,000 observations.

    Raises
    ------
    ParamsError
        For a file that is not such a model, or for another world.
    """
    if env not in (known := {**IDS, **ROADS}):
        raise ParamsError(f"environment {env!r} is unknown{suggestion(env, known)}")
    if algorithm is not None and algorithm not in ALGORITHMS:
        raise ParamsError(f"algorithm {algorithm!r} is unknown{suggestion(algorithm, ALGORITHMS)}")
    if zeroed not in MASKS:
        raise ParamsError(f"zeroed = {zeroed!r} is unknown{suggestion(zeroed, MASKS)}")
    params = domain_of_id(env).params({**known[env], **(world or {})})
    check_new(out)
    kind = ALGORITHMS[algorithm or kind_of(path)]
    try:
        module = importlib.import_module(kind.module)
    except ImportError as error:
        raise ParamsError(f"export needs {kind.module} ({error}): pip install -e '.[train]' in the clone") from error
    try:
        model = getattr(module, kind.name).load(path, device="cpu")
    except Exception as error:  # of whatever kind: it runs code from the file
        text = " ".join(f"{type(error).__name__}: {error}".split())
        raise ParamsError(f"{os.fspath(path)!r} cannot be read as {kind.name}: {text}") from error
    normalisation = None if statistics is None else _normalisation(statistics, model)
    if statistics is None and saw_normalised(model):
        raise ParamsError(
            f"{os.fspath(path)!r} was trained on observations that VecNormalize had normalised: give the file of its "
            "statistics, which VecNormalize.save writes, with --statistics"
        )
    inputs = Inputs(normalisation, stack=_stacked(model.observation_space.shape[0], params), zeroed=zeroed)
    return export(model, params, out, inputs, training={"source": Path(path).name})


def _normalisation(path: str | os.PathLike[str], model: Any) -> Normalisation | None:
    """The statistics of a `VecNormalize` in a file, which must be of the model's observations."""
    try:
        with open(path, "rb") as file:
            found = Normalisation.of(pickle.load(file))
    except Exception as error:  # of whatever kind: it runs code from the file
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        raise ParamsError(f"{os.fspath(path)!r} cannot be read as what VecNormalize.save writes: {text}") from error
    if found is not None and found.mean.shape != model.observation_space.shape:
        raise ParamsError(
            f"{os.fspath(path)!r} is of observations of shape {found.mean.shape}, and the model sees "
            f"{model.observation_space.shape}"
        )
    return found


def _stacked(width: int, params: Params) -> int:
    """How many observations stacked make so many numbers."""
    fields = len(domain_of(params).fields(params))
    stack, rest = divmod(width, fields)
    if rest or not stack:
        raise ParamsError(
            f"the model does not fit the world: it sees {width} numbers, not a multiple of {fields}; name the "
            "environment it was trained in (--env) and what differed from it (--set intruders=2)"
        )
    return stack


def kind_of(path: str | os.PathLike[str]) -> str:
    """The algorithm whose settings a `.zip` of SB3 names; runs nothing from it.

    Raises
    ------
    ParamsError
        If it is no such file or names none.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            if archive.getinfo("data").file_size > DATA_MAX:
                raise ParamsError(f"{os.fspath(path)!r} is not a model of SB3: its data has more than {DATA_MAX} bytes")
            data = json.loads(archive.read("data"))
        policy = data["policy_class"]["__module__"]
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        if isinstance(error, ParamsError):
            raise
        raise ParamsError(f"{os.fspath(path)!r} is not a model of SB3 (.zip): {error}") from error
    if policy == "sb3_contrib.common.recurrent.policies":
        return "recurrent-ppo"
    if policy == "stable_baselines3.sac.policies":
        return "sac"
    if policy == "stable_baselines3.common.policies" and "clip_range" in data:
        return "ppo"
    raise ParamsError(f"{os.fspath(path)!r} does not tell its algorithm; name it with --algorithm")
