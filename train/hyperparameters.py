"""Every hyperparameter of the learners, checked as the parameters of the world are.

Defaults are those of Stable-Baselines3. Left out are the arguments that are code (noise and buffer classes), and SAC's
state-dependent exploration, with which its policy cannot be exported.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

from rss_gym.baselines.masks import MASKS
from rss_gym.baselines.policy_files import LAYERS_LIMIT, STACK_LIMIT, UNITS_LIMIT
from rss_gym.params import Group, ParamsError, choice, number, of_kind
from rss_gym.schema import Kind, listed, real, text, whole

Activation = Literal["tanh", "relu"]


@dataclass(frozen=True, slots=True)
class Schedule:
    """A value that changes linearly over the training, from `start` to `end` times `start`."""

    start: float
    end: float = 1.0


def within(low: float, high: float) -> dict[str, Kind]:
    """Metadata of a field that is a number in [low, high], or a table with such a `start`, and `end`."""
    parts = {"start": real(low, high), "end": real(0.0, 1.0)}

    def table(value: Any) -> Mapping[str, Any]:
        if isinstance(value, Schedule):
            value = dataclasses.asdict(value)
        return value if isinstance(value, Mapping) else {"start": value}

    def test(value: Any) -> bool:
        given = table(value)
        return "start" in given and all(name in parts and parts[name].test(part) for name, part in given.items())

    words = f"a number in [{low:g}, {high:g}] or {{start, end}}, whose end is a fraction of start in [0, 1]"
    return {"kind": Kind(test, words, plain=lambda value: Schedule(**{n: float(v) for n, v in table(value).items()}))}


def automatic() -> Any:
    """A field that is a number or "auto"."""
    number = real(-1e12, 1e12)
    return of_kind("auto", Kind(lambda value: value == "auto" or number.test(value), 'a number or "auto"'))


def units(*default: int) -> Any:
    """A field that lists the units of hidden layers."""
    words = f"a list of the units, 1 to {UNITS_LIMIT}, of at most {LAYERS_LIMIT} layers"
    return of_kind(default, listed(0, LAYERS_LIMIT, words, whole(1, UNITS_LIMIT))._replace(plain=tuple))


@dataclass(frozen=True, slots=True, kw_only=True)
class Ppo(Group):
    """Of PPO. Zero in `clip_range_vf` or `target_kl` means none.

    `use_sde` explores by noise that depends on the state (Raffin et al. 2022), with a new matrix every
    `sde_sample_freq` decisions, -1 for one a rollout.
    """

    learning_rate: Schedule = field(default=Schedule(3e-4), metadata=within(1e-8, 1.0))
    n_steps: int = number(2048, 1, 10**6)  # decisions a row and update
    batch_size: int = number(64, 2, 10**7)
    n_epochs: int = number(10, 1, 1000)
    gamma: float = number(0.99, 0.0, 1.0)
    gae_lambda: float = number(0.95, 0.0, 1.0)
    clip_range: Schedule = field(default=Schedule(0.2), metadata=within(1e-6, 10.0))
    clip_range_vf: Schedule = field(default=Schedule(0.0), metadata=within(0.0, 1e6))
    normalize_advantage: bool = True
    ent_coef: float = number(0.0, 0.0, 10.0)
    vf_coef: float = number(0.5, 0.0, 100.0)
    max_grad_norm: float = number(0.5, 1e-6, 1e6)
    target_kl: float = number(0.0, 0.0, 100.0)
    use_sde: bool = False
    sde_sample_freq: int = number(-1, -1, 10**6)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecurrentPpo(Ppo):
    """Of RecurrentPPO."""

    n_steps: int = number(128, 1, 10**6)
    batch_size: int = number(128, 2, 10**7)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sac(Group):
    """Of SAC. One of `train_freq` is a decision of every row; `gradient_steps` -1 is one a decision of a row."""

    learning_rate: Schedule = field(default=Schedule(3e-4), metadata=within(1e-8, 1.0))
    buffer_size: int = number(1_000_000, 1, 10**9)
    learning_starts: int = number(100, 0, 10**9)
    batch_size: int = number(256, 1, 10**6)
    tau: float = number(0.005, 1e-6, 1.0)
    gamma: float = number(0.99, 0.0, 1.0)
    train_freq: int = number(1, 1, 10**6)
    gradient_steps: int = number(1, -1, 10**6)
    n_steps: int = number(1, 1, 1000)
    ent_coef: float | str = automatic()
    target_update_interval: int = number(1, 1, 10**6)
    target_entropy: float | str = automatic()


@dataclass(frozen=True, slots=True, kw_only=True)
class Pathwise(Group):
    """Of `rss_gym.train.pathwise`.

    Parameters
    ----------
    learning_rate : Schedule
    softness_m : float
        Standard deviation of the normal distribution functions that stand for the steps of the cost at an sNMAC and
        a collision.
    softness_sigmas : float
        What is added to it in quadrature, in standard deviations of the track.
    gradient_limit_m : float
        Greatest gradient of a flight's cost by the action of one decision.
    manoeuvre_price_m : float
        The price of a flight that leaves its path by more than 3 m, on top of its cost.
    near_share : float
        Share of the rows that fly encounters again in which an earlier flight came near; 0 flies new ones alone.
    near_m : float
        The separation below which an encounter is flown again.
    """

    learning_rate: Schedule = field(default=Schedule(3e-3), metadata=within(1e-8, 1.0))
    softness_m: float = number(3.5, 0.01, 100.0)
    softness_sigmas: float = number(0.0, 0.0, 100.0)
    gradient_limit_m: float = number(20.0, 1e-3, 1e6)
    manoeuvre_price_m: float = number(0.0, 0.0, 1e6)
    near_share: float = number(0.0, 0.0, 0.95)
    near_m: float = number(20.0, 0.0, 1e6)


@dataclass(frozen=True, slots=True, kw_only=True)
class PpoNetwork(Group):
    """Actor and critic of PPO, each with these layers; `pathwise` learns the actor alone."""

    net_arch: tuple[int, ...] = units(64, 64)
    activation: str = choice("tanh", Activation)
    zeroed: str = choice("nothing", MASKS)
    log_std_init: float = number(0.0, -10.0, 2.0)
    ortho_init: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class RecurrentNetwork(PpoNetwork):
    """The same behind an LSTM, one for the actor and by default another one for the critic."""

    lstm_hidden_size: int = number(256, 1, UNITS_LIMIT)
    enable_critic_lstm: bool = True
    shared_lstm: bool = False

    def __post_init__(self) -> None:
        """Check that the critic has at most one LSTM."""
        Group.__post_init__(self)
        if self.shared_lstm and self.enable_critic_lstm:
            raise ParamsError("shared_lstm = true needs enable_critic_lstm = false")


@dataclass(frozen=True, slots=True, kw_only=True)
class SacNetwork(Group):
    """Actor and critics of SAC."""

    net_arch: tuple[int, ...] = units(256, 256)
    activation: str = choice("relu", Activation)
    zeroed: str = choice("nothing", MASKS)
    n_critics: int = number(2, 1, 10)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vec(Group):
    """The rows and what stands between them and the learner.

    Without `normalise_reward` the loss of the value, for rewards down to -100, takes all that the gradient's clip lets
    through.
    """

    n_envs: int = number(256, 1, 1 << 16)
    stack: int = number(1, 1, STACK_LIMIT)
    normalise_reward: bool = True
    normalise_observation: bool = False
    clip_reward: float = number(10.0, 1e-3, 1e9)
    clip_observation: float = number(10.0, 1e-3, 1e6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Imitation(Group):
    """What the actor learns from a scripted rule before its own training; nothing where `episodes` is zero.

    The rows are flown by the rule, disturbed so that states off its path are seen too, and the actor is fitted to the
    rule's actions, by least squares or, where these are discrete, least cross-entropy.

    Parameters
    ----------
    policy : str
        As on the command line, `cbf` or `mpc:radius_m=35`; it must command what the world's policy does.
    episodes : int
        Encounters to fly.
    disturbance : float
        Standard deviation of what is added to each action, of range 1; it is correlated from decision to decision.
        Of discrete actions the share that is replaced at random.
    epochs, batch_size : int
    learning_rate : float
        The greatest of the one cycle that it goes through.
    critic_steps : int
        So many first decisions of the training teach the critic alone: one that knows nothing spoils the actor.
    competes : bool
        Whether the imitated policy may be kept as the best.
    """

    policy: str = of_kind("mpc", text())  # the recipe checks the rest of it
    episodes: int = number(0, 0, 10**5)  # all in memory: 50 kB each
    disturbance: float = number(0.06, 0.0, 10.0)
    epochs: int = number(12, 1, 1000)
    batch_size: int = number(4096, 1, 10**6)
    learning_rate: float = number(4e-3, 1e-8, 1.0)
    critic_steps: int = number(0, 0, 10**12)
    competes: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation(Group):
    """How often the policy is flown on split `validation`, and over how many encounters, the same each time."""

    every_steps: int = number(1_000_000, 1, 10**12)
    episodes: int = number(2000, 1, 10**7)


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkpoint(Group):
    """How often the training is saved: what an end by force costs at most."""

    every_steps: int = number(500_000, 1, 10**12)


@dataclass(frozen=True, slots=True)
class Algorithm:
    """A learner: where its class is, its policy's name there, and the tables of a recipe for it."""

    module: str
    name: str
    policy_name: str
    hyperparameters: type[Ppo | Sac | Pathwise]
    network: type[PpoNetwork | SacNetwork]


ALGORITHMS: dict[str, Algorithm] = {
    "pathwise": Algorithm("rss_gym.train.pathwise", "Pathwise", "MlpPolicy", Pathwise, PpoNetwork),
    "ppo": Algorithm("stable_baselines3", "PPO", "MlpPolicy", Ppo, PpoNetwork),
    "recurrent-ppo": Algorithm("sb3_contrib", "RecurrentPPO", "MlpLstmPolicy", RecurrentPpo, RecurrentNetwork),
    "sac": Algorithm("stable_baselines3", "SAC", "MlpPolicy", Sac, SacNetwork),
}


G = TypeVar("G", bound=Group)


def group(section: str, defaults: G, tables: Mapping[str, Any]) -> G:
    """A section of a recipe's tables over its defaults; errors name the section."""
    try:
        return defaults.replace(**tables.get(section, {}))
    except ParamsError as error:
        raise ParamsError(f"[{section}]: {error}") from error
