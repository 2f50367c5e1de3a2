"""Wrong input is refused in one sentence that names field and value, and leaves the environment as it was."""

import datetime
import re

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from rss_gym.env import EncounterEnv
from rss_gym.params import Params, ParamsError
from rss_gym.vector import EncounterVectorEnv

ID = "rss_gym/Encounter-v0"
TYPES = (ValueError, TypeError)


def made(vector, **keywords):
    return EncounterVectorEnv(2, **keywords) if vector else EncounterEnv(**keywords)


@pytest.fixture(params=[False, True], ids=["single", "vector"])
def vector(request):
    return request.param


# -- making -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("rss_gym/Encountr-v0", "Encounter"),
        ("rss_gym/Encounter-v7", "v7"),
        ("rss_gim/Encounter-v0", "rss_gim"),
        ("rss_gym/Encounter", None),
    ],
)
def test_unknown_id(name, says):
    """Gymnasium's own error."""
    if says is None:
        with pytest.warns(UserWarning, match="latest versioned"):
            assert gym.make(name).spec.id == ID
        return
    with pytest.raises(gym.error.UnregisteredEnv, match=says):
        gym.make(name)
    with pytest.raises(gym.error.UnregisteredEnv, match=says):
        gym.make_vec(name)


@pytest.mark.parametrize(
    ("keywords", "says"),
    [
        ({"information": "position"}, ["information", "'position'", "did you mean 'positions'", "oracle", "ranges"]),
        ({"channel": "quadcoptr"}, ["channel", "'quadcoptr'", "did you mean 'quadcopter'", "wifi-walk"]),
        ({"channel": ["paper", "quadcoptr"]}, ["'quadcoptr'", "did you mean 'quadcopter'"]),
        ({"announce": 3.0}, ["'announce'", "did you mean 'announce_s'"]),
        ({"estimater": "ls"}, ["'estimater'", "did you mean 'estimator'"]),
        ({"estimator": "ekf"}, ["estimator", "'ekf'", "ekf-coloured"]),
        ({"tracker": "fuse"}, ["tracker", "'fuse'", "did you mean 'fused'", "latest", "bearings"]),
        ({"action": "Discrete"}, ["action", "'Discrete'", "did you mean 'discrete'"]),
        ({"agent": "gps"}, ["agent", "'gps'", "gnss"]),
        ({"zone": "adaptiv"}, ["zone", "'adaptiv'", "did you mean 'adaptive'"]),
        ({"families": "headon"}, ["family", "'headon'", "did you mean 'head-on'"]),
        ({"families": ["crossing", "headon"]}, ["'headon'", "did you mean 'head-on'"]),
        ({"families": 3}, ["families", "3"]),
        ({"families": []}, ["families"]),
        ({"render_mode": "rgb"}, ["render_mode", "'rgb'", "did you mean 'rgb_array'"]),
        ({"channel": {"path_loss_fctor": 2.0}}, ["'path_loss_fctor'", "did you mean 'path_loss_factor'"]),
        ({"channel": []}, ["channel", "empty"]),
        ({"channel": None}, ["channel", "None"]),
        ({"channel": 2.7}, ["channel", "2.7"]),
        ({"channel": {"packet_loss": 1.0}}, ["packet_loss", "1.0"]),
        ({"channel": {"path_loss_factor": float("nan")}}, ["path_loss_factor", "nan"]),
        ({"announce_s": float("nan")}, ["announce_s", "nan"]),
        ({"announce_s": float("inf")}, ["announce_s", "inf"]),
        ({"announce_s": -1.0}, ["announce_s", "-1"]),
        ({"announce_s": "30"}, ["announce_s", "'30'"]),
        ({"announce_s": True}, ["announce_s", "True"]),
        ({"intruders": 0}, ["intruders", "0"]),
        ({"intruders": 9}, ["intruders", "9"]),
        ({"intruders": 2.0}, ["intruders", "2.0"]),
        ({"planar": 1}, ["planar", "1"]),
        ({"params": "paper"}, ["params", "str"]),
        ({"params": 3}, ["params", "int"]),
        ({"params": {"chanels": []}}, ["'chanels'", "did you mean 'channels'"]),
        ({"params": {"clock": {"tik_s": 0.1}}}, ["clock", "'tik_s'", "did you mean 'tick_s'"]),
        ({"params": {"clock": 3}}, ["clock", "3"]),
        # Contradictions.
        ({"information": "ranges", "intruder": "rss"}, ["ranges", "intruder", "'rss'"]),
        ({"information": "ranges", "agent": "rss"}, ["ranges", "agent", "'rss'"]),
        ({"information": "ranges", "tracker": "fused"}, ["ranges", "'fused'", "bearings"]),
        ({"tracker": "bearings"}, ["positions", "'bearings'", "fused"]),
        ({"decision_s": 0.25}, ["decision_s", "tick_s", "0.25"]),
        ({"decision_s": 0.05}, ["decision_s", "tick_s", "0.05"]),
        ({"intruders": 2, "intruders_min": 3}, ["intruders_min", "3", "2"]),
        ({"cruise_min_mps": 4.5}, ["cruise_min_mps", "4.5", "cruise_max_mps"]),
        ({"cruise_max_mps": 5.0}, ["cruise_max_mps", "5", "speed_max_mps"]),
        ({"closing_min_mps": 9.0}, ["closing_min_mps", "9", "cruise_max_mps"]),
        ({"start_range_min": 2.0}, ["start_range_min", "2", "start_range_max"]),
        ({"tail_min_s": 50.0}, ["tail_min_s", "50", "tail_max_s"]),
    ],
    ids=repr,
)
def test_parameters(vector, keywords, says):
    with pytest.raises(ParamsError) as caught:
        made(vector, **keywords)
    message = str(caught.value)
    assert "\n" not in message
    for part in says:
        assert part in message


@pytest.mark.parametrize("keywords", [{"information": "papr"}, {"announce": 3.0}, {"announce_s": float("nan")}])
def test_parameters_through_make(keywords):
    """The same sentence reaches the user of `gym.make` and `gym.make_vec`."""
    with pytest.raises(ParamsError, match=next(iter(keywords))):
        gym.make(ID, **keywords)
    with pytest.raises(ParamsError, match=next(iter(keywords))):
        gym.make_vec(ID, num_envs=2, **keywords)


@pytest.mark.parametrize("num_envs", [0, -1, 1.0, "2", None, True])
def test_num_envs(num_envs):
    with pytest.raises(ParamsError, match=f"num_envs .*{re.escape(repr(num_envs))}"):
        EncounterVectorEnv(num_envs)


@pytest.mark.parametrize("mode", ["Nextstep", "next_step", None, 1, True])
def test_autoreset_mode(mode):
    with pytest.raises(ParamsError, match=r"autoreset_mode .*NextStep"):
        EncounterVectorEnv(1, autoreset_mode=mode)


# -- files of channels ------------------------------------------------------------------------------------------------

FILES = {
    "truncated": (b"[channel]\npath_loss_factor = ", "not readable TOML"),
    "binary": (bytes(range(256)) * 4, "not readable TOML"),
    "utf-16": ("[channel]\npath_loss_factor = 2.0\n".encode("utf-16"), "not readable TOML"),
    "empty": (b"", "[channel]"),
    "no-table": (b"path_loss_factor = 2.0\n", "'path_loss_factor'"),
    "wrong-key": (b"[channel]\npath_loss_facter = 2.0\n", "did you mean 'path_loss_factor'"),
    "wrong-type": (b'[channel]\npath_loss_factor = "2.0"\n', "path_loss_factor must be a number in [1, 8], got '2.0'"),
    "date": (b"[channel]\npath_loss_factor = 2020-01-01\n", "path_loss_factor must be a number"),
    "nan": (b"[channel]\npath_loss_factor = nan\n", "path_loss_factor must be a number in"),
    "infinite": (b"[channel]\nwhite_variance_db2 = inf\n", "white_variance_db2 must be a number in"),
    "out-of-range": (b"[channel]\npacket_loss = 1.5\n", "packet_loss must be a number in"),
    "duplicate": (b"[channel]\npacket_loss = 0.1\npacket_loss = 0.2\n", "not readable TOML"),
    "number-for-table": (b"channel = 3\n", "[channel]"),
    "misplaced-key": (b"packet_loss = 0.1\n[channel]\npath_loss_factor = 2.0\n", "'packet_loss'"),
    "large": (b"#" * 2**20 + b"\n[channel]\n", "larger than 65,536 bytes"),
    "deep": (b"a = " + b"[" * 20000, "not readable TOML"),
    "huge-number": (b"[channel]\npath_loss_factor = 1" + b"0" * 400 + b"\n", "path_loss_factor must be a number in"),
    "absurd-number": (b"[channel]\npath_loss_factor = 1" + b"0" * 5000 + b"\n", "channel file"),
}


@pytest.mark.parametrize("kind", FILES)
def test_channel_file(tmp_path, kind):
    content, says = FILES[kind]
    path = tmp_path / f"{kind}.toml"
    path.write_bytes(content)
    for source in (path, str(path), [path, "paper"]):
        with pytest.raises(ParamsError) as caught:
            EncounterEnv(channel=source)
        assert str(path) in str(caught.value)
        assert says in str(caught.value)
        assert "\n" not in str(caught.value)


def test_channel_file_that_names_itself(tmp_path):
    path = tmp_path / "loop.toml"
    path.write_text(f'channel = "{path.as_posix()}"\n')
    with pytest.raises(ParamsError, match=r"loop\.toml"):
        EncounterEnv(channel=path)


@pytest.mark.parametrize("source", ["no/such/channel.toml", "such.toml", "a\0b", "", ".", "x" * 5000, "/"])
def test_missing_channel_file(source):
    with pytest.raises(ParamsError, match="channel"):
        EncounterEnv(channel=source)


def test_folder_as_channel_file(tmp_path):
    with pytest.raises(ParamsError, match=re.escape(str(tmp_path))):
        EncounterEnv(channel=tmp_path)


def test_good_channel_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[channel]\npath_loss_factor = 3\nwhite_variance_db2 = 2.5\n")
    env = EncounterEnv(channel=[path, "paper"])
    assert env.params.channels[0].path_loss_factor == 3.0
    assert env.params == Params.of(channel=[{"path_loss_factor": 3, "white_variance_db2": 2.5}, "paper"])


# -- actions ----------------------------------------------------------------------------------------------------------

BOX = {
    "too-long": (np.zeros(3), ValueError, "shape"),
    "too-short": (np.zeros(1), ValueError, "shape"),
    "nested": (np.zeros((1, 2)), ValueError, "shape"),
    "scalar": (0.0, ValueError, "shape"),
    "empty": ([], TYPES, "shape"),
    "none": (None, TypeError, "real numbers"),
    "text": ("up", TypeError, "real numbers"),
    "texts": (["0", "1"], TypeError, "real numbers"),
    "objects": ([object(), 1.0], TypeError, "real numbers"),
    "complex": ([1j, 0.0], TypeError, "real numbers"),
    "bool": ([True, False], TypeError, "real numbers"),
    "dates": (np.array(["2020-01-01"] * 2, "M8[D]"), TypeError, "real numbers"),
    "huge-integer": ([10**400, 0], TypeError, "real numbers"),
    "nan": ([np.nan, 0.0], ValueError, "not finite"),
    "infinite": ([0.0, -np.inf], ValueError, "not finite"),
    "infinities": ([np.inf, -np.inf], ValueError, "not finite"),
}
DISCRETE = {
    "negative": (-1, ValueError, "-1"),
    "too-large": (9, ValueError, "9"),
    "very-large": (2**63 - 1, ValueError, str(2**63 - 1)),
    "real": (1.0, TypeError, "whole numbers"),
    "array": ([1, 2], ValueError, "shape"),
    "bool": (True, TypeError, "whole numbers"),
    "none": (None, TypeError, "whole numbers"),
    "nan": (np.nan, TypeError, "whole numbers"),
    "text": ("1", TypeError, "whole numbers"),
}
CASES = {f"box-{name}": ("velocity", *case) for name, case in BOX.items()}
CASES |= {f"discrete-{name}": ("discrete", *case) for name, case in DISCRETE.items()}


@pytest.mark.parametrize("case", CASES)
def test_action(case):
    kind, wrong, error, says = CASES[case]
    env, twin = EncounterEnv(action=kind), EncounterEnv(action=kind)
    env.reset(seed=0)
    twin.reset(seed=0)
    good = env.action_space.sample()
    env.step(good)
    twin.step(good)
    with pytest.raises(error, match=says):
        env.step(wrong)
    for _ in range(3):
        assert data_equivalence(env.step(good), twin.step(good), exact=True)


@pytest.mark.parametrize("case", [name for name in CASES if "bool" not in name])  # NumPy takes a bool among numbers
@pytest.mark.parametrize("row", [0, 1])
def test_action_of_one_row(case, row):
    """A wrong row, among good ones, moves none of them."""
    kind, wrong, _, _ = CASES[case]
    envs, twin = EncounterVectorEnv(2, action=kind), EncounterVectorEnv(2, action=kind)
    envs.reset(seed=0)
    twin.reset(seed=0)
    good = envs.action_space.sample()
    actions = list(good)
    actions[row] = wrong
    with pytest.raises(TYPES):  # rows of different shapes or types are NumPy's to refuse
        envs.step(actions)
    for _ in range(3):
        assert data_equivalence(envs.step(good), twin.step(good), exact=True)


@pytest.mark.parametrize("shape", [(2,), (3, 2), (2, 3), (2, 2, 1), (0, 2)])
def test_actions_of_wrong_shape(shape):
    envs = EncounterVectorEnv(2)
    envs.reset(seed=0)
    with pytest.raises(ValueError, match=re.escape(str(shape))):
        envs.step(np.zeros(shape))


def test_message_names_the_row():
    envs = EncounterVectorEnv(4)
    envs.reset(seed=0)
    with pytest.raises(ValueError, match=r"row 2 .*nan"):
        envs.step([[0, 0], [1, 1], [np.nan, 0], [0, 0]])


@pytest.mark.filterwarnings("error")
def test_finite_actions_are_clipped():
    """However large, and of any real type."""
    env, twin = EncounterEnv(), EncounterEnv()
    for one, two in [
        ([1e308, -1e308], [1.0, -1.0]),
        ([1e308, 1e308], [1, 1]),
        (np.array([3, -2], np.int8), (1.0, -1.0)),
        (np.array([200, 0], np.uint8), [1.0, 0.0]),
        (np.array([0.5, 2.0], np.float16), [0.5, 1.0]),
        (np.array([0.5, 2.0], ">f8"), [0.5, 1.0]),
        (np.zeros((2, 2)).T[0], [-0.0, 0.0]),
    ]:
        env.reset(seed=0)
        twin.reset(seed=0)
        assert data_equivalence(env.step(one), twin.step(two), exact=True)


def test_the_callers_action_is_not_changed(vector):
    env = made(vector)
    env.reset(seed=0)
    action = np.full(env.action_space.shape, 7.0)
    env.step(action)
    assert (action == 7.0).all()


# -- order of calls ---------------------------------------------------------------------------------------------------


def test_step_before_reset(vector):
    env = made(vector)
    with pytest.raises(gym.error.ResetNeeded, match="reset"):
        env.step(env.action_space.sample())
    env.reset(seed=0)
    env.step(env.action_space.sample())
    with pytest.raises(gym.error.ResetNeeded):
        gym.make(ID).step(np.zeros(2))


def test_step_after_the_end():
    env = EncounterEnv(tail_min_s=0.0, tail_max_s=0.0)
    env.reset(seed=0)
    ended = False
    while not ended:
        last = env.step(np.zeros(2))
        ended = last[2] or last[3]
    state = env.batch.state.aircraft.tobytes()
    for _ in range(2):
        with pytest.raises(gym.error.ResetNeeded, match="reset"):
            env.step(np.zeros(2))
    assert env.batch.state.aircraft.tobytes() == state
    env.reset()
    env.step(np.zeros(2))


def test_step_of_an_ended_row_without_autoreset():
    envs = EncounterVectorEnv(3, autoreset_mode="Disabled", tail_min_s=0.0, tail_max_s=0.0)
    envs.reset(seed=0)
    ended = np.zeros(3, bool)
    while not ended.any():
        _, _, terminated, truncated, _ = envs.step(np.zeros((3, 2)))
        ended = terminated | truncated
    with pytest.raises(gym.error.ResetNeeded, match=rf"row {np.flatnonzero(ended)[0]} .*reset_mask"):
        envs.step(np.zeros((3, 2)))
    envs.reset(options={"reset_mask": ended})
    envs.step(np.zeros((3, 2)))


def test_rows_that_were_never_reset():
    envs = EncounterVectorEnv(3, autoreset_mode="Disabled")
    envs.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(gym.error.ResetNeeded):
        envs.step(np.zeros((3, 2)))
    envs.reset(options={"reset_mask": np.array([False, True, False])})
    envs.step(np.zeros((3, 2)))


def test_close_twice(vector):
    env = made(vector, render_mode="rgb_array")
    env.reset(seed=0)
    env.close()
    env.close()


# -- seeds and options of a reset -------------------------------------------------------------------------------------

SEEDS = [
    -1,
    2**63,
    1.0,
    np.float64(1.0),
    "1",
    True,
    np.bool_(True),
    b"1",
    1j,
    {},
    datetime.date(2020, 1, 1),
    float("nan"),
    np.array(1),
]


def unharmed(vector, wrong, error, says):
    """A wrong reset raises, and the environment goes on with the episode and with the ones to come."""
    env, twin = made(vector), made(vector)
    for e in (env, twin):
        e.reset(seed=5, options={"split": "validation", "episode": 3})
        e.action_space.seed(0)
    action = env.action_space.sample()
    env.step(action)
    twin.step(action)
    with pytest.raises(error, match=says):
        wrong(env)
    assert data_equivalence(env.step(action), twin.step(action), exact=True)
    assert data_equivalence(env.reset(), twin.reset(), exact=True)
    assert env.np_random.bit_generator.state == twin.np_random.bit_generator.state


@pytest.mark.parametrize("seed", SEEDS, ids=repr)
def test_seed(vector, seed):
    unharmed(
        vector,
        lambda env: env.reset(seed=seed),
        ValueError,
        re.escape(f"seed must be a whole number in [0, 2**63), got {seed!r}"),
    )


@pytest.mark.parametrize("seed", [[1], [1, 2, 3], [], [1, -2], [1, 2.0], [1, True], [1, "2"], [[1], [2]]], ids=repr)
def test_list_of_seeds(seed):
    unharmed(True, lambda env: env.reset(seed=seed), ValueError, "seed")
    with pytest.raises(ValueError, match="seed"):
        EncounterEnv().reset(seed=seed)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"spilt": "train"}, "'spilt' .*did you mean 'split'"),
        ({"split": "test"}, "split.*'test'.*suite"),
        ({"split": None}, "split.*None"),
        ({"split": 1}, "split.*1"),
        ({"split": ["train", "suite"]}, "split.*'train'"),
        ({"episode": -1}, "episode.*-1"),
        ({"episode": 1.0}, r"episode.*1\.0"),
        ({"episode": True}, "episode.*True"),
        ({"episode": "1"}, "episode.*'1'"),
        ({"episode": 2**64}, "episode.*18446744073709551616"),
        ({"episode": [1, 2, 3]}, "episode.*3"),
        ({"episode": [[1], [1, 2]]}, "episode"),
        ({"episode": []}, "episode"),
        ({"episode": None}, "episode.*None"),
        ({"episode": np.array([0.5, 1.0])}, "episode"),
        ({"split": "suite", "episode": -1}, "episode.*-1"),
        ({1: 2}, "1"),
    ],
    ids=repr,
)
def test_options(vector, options, says):
    given = dict(options)
    unharmed(vector, lambda env: env.reset(options=options), ValueError, says)
    unharmed(vector, lambda env: env.reset(seed=8, options=options), ValueError, says)
    assert options.keys() == given.keys()


@pytest.mark.parametrize("options", ["suite", ["split"], 3, datetime.date(2020, 1, 1)], ids=repr)
def test_options_of_wrong_type(vector, options):
    unharmed(vector, lambda env: env.reset(options=options), TypeError, "options")


@pytest.mark.parametrize(
    "mask",
    [
        [True, False],
        np.array([1, 0]),
        np.array([True]),
        np.array([[True, False]]),
        np.array([False, False]),
        np.array([True, False, True]),
        None,
        "all",
    ],
    ids=repr,
)
def test_reset_mask(mask):
    unharmed(True, lambda env: env.reset(options={"reset_mask": mask}), (TypeError, ValueError), "reset_mask")
    unharmed(True, lambda env: env.reset(seed=3, options={"reset_mask": mask}), (TypeError, ValueError), "reset_mask")


def test_single_environment_has_no_reset_mask():
    with pytest.raises(ValueError, match="'reset_mask' is unknown"):
        EncounterEnv().reset(options={"reset_mask": np.array([True])})


def test_an_impossible_world_is_refused():
    """When no encounter meets the limits, the sentence says which."""
    env = EncounterEnv(families="overtaking", cruise_min_mps=4.0, cruise_max_mps=4.0, closing_min_mps=3.0)
    with pytest.raises(ParamsError, match=r"overtaking.*closing_min_mps"):
        env.reset(seed=0)
