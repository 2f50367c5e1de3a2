"""What the evaluator takes for one policy: a specification, or the numbers of a learned one wherever they lie."""

import json
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from rss_gym import baselines
from rss_gym.baselines.policy_files import FORMAT, Network
from rss_gym.eval.policies import entry
from rss_gym.observation import fields
from rss_gym.params import Params, ParamsError


def write(folder, value):
    """A policy folder of one linear layer, all its weights alike."""
    params = Params()
    names = [field.name for field in fields(params)]
    network = Network(layers=())
    folder.mkdir(parents=True)
    tensors = {name: np.full(shape, value, np.float32) for name, shape in network.shapes(params).items()}
    save_file(tensors, folder / "policy.safetensors")
    document = {
        "format": FORMAT,
        "network": {**network.__dict__, "layers": []},
        "interface": {"information": params.interface.information},
        "observation": names,
        "training": {},
    }
    (folder / "policy.json").write_text(json.dumps(document))
    return str(folder)


@pytest.mark.parametrize("around", ["", "cbf+", "cbf:radius_m=20+"])
def test_hash_of_a_learned_policy_is_that_of_its_files(around, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    here, there, other = (write(tmp_path / name, value) for name, value in (("a", 0.0), ("b", 0.0), ("c", 0.1)))
    one, two, three = (entry(f"{around}{name}", Params()).hash for name in ("a", "b", "c"))
    assert one == two != three
    assert baselines.is_folder(here) and there != other


def test_a_path_is_a_folder_even_if_a_policy_has_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    place = write(tmp_path / "orca", 0.0)
    assert entry(Path("orca"), Params()).hash == entry(Path(place), Params()).hash != entry("orca", Params()).hash
    assert entry(Path("orca"), Params()).name == "orca"
    with pytest.raises(ParamsError, match="nowhere"):
        entry(Path("nowhere"), Params())


def test_the_filter_goes_round_a_folder_by_any_path_and_numbers_keep_their_plus(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    place = write(tmp_path / "a", 0.0)
    assert len({entry(f"cbf+{path}", Params()).hash for path in ("a", "./a", place)}) == 1
    assert baselines.parse("cbf:radius_m=+2.5e+1,lookahead_s=+.5+none").base == "none"


def test_filter_and_what_it_goes_round_count():
    specs = ("cbf+none", "cbf+orthogonal", "cbf:radius_m=20+none", "none", "cbf+cbf+none")
    assert len({entry(spec, Params()).hash for spec in specs}) == len(specs)
