"""What a training shows on its way, and what it says at its end."""

import contextlib
import io
import re

import pytest

pytest.importorskip("stable_baselines3", reason="stable-baselines3 (extra `train`) is not installed")

from rss_gym.train import loop, recipe, run


class Bar:
    """Keeps what it is told."""

    def __init__(self, show, **keywords):
        self.total, self.n, self.seen, self.texts = keywords["total"], keywords.get("initial", 0), [], []
        Bar.last = self

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def update(self, count):
        self.n += count
        self.seen.append(self.n)

    def set_postfix(self, values, refresh=True):
        self.texts.append(values)

    def set_postfix_str(self, text, refresh=True):
        self.texts.append(text)

    def refresh(self):
        pass


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """The bar of a training, and what was printed."""
    changes = {"recipe.steps": 1500, "vec.n_envs": 64, "algorithm.n_steps": 16, "algorithm.batch_size": 256}
    changes |= {"algorithm.n_epochs": 1, "policy.net_arch": [8], "imitation.episodes": 64, "imitation.epochs": 2}
    changes |= {"validation.every_steps": 1024, "validation.episodes": 40, "checkpoint.every_steps": 1024}
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()) as out:
        patch.setattr(loop, "progress_bar", Bar)
        run.start(recipe.load("ppo", changes), tmp_path_factory.mktemp("progress") / "run", seeds=1)
    return Bar.last, out.getvalue()


def test_it_never_passes_its_end_and_is_not_silent_before_its_start(trained):
    bar, _ = trained
    assert max(bar.seen) == bar.total == 1500
    texts = [text for text in bar.texts if isinstance(text, str)]
    assert any("encounters" in text for text in texts) and any("pass 2 of 2" in text for text in texts)
    pairs = re.findall(r"([\d,]+) of ([\d,]+) enc", str(texts))
    shown = [int(a.replace(",", "")) / int(b.replace(",", "")) for a, b in pairs]
    assert shown == sorted(shown)


def test_no_rate_is_shown_before_every_row_can_have_ended(trained):
    bar, _ = trained
    assert [values for values in bar.texts if isinstance(values, dict)] == []


def test_it_says_at_its_end_whether_it_beat_its_start_the_rule_and_the_best_scripted_policy(trained):
    _, out = trained
    (line,) = [line for line in out.splitlines() if line.startswith("the agent costs ")]
    assert re.search(r"(NOT below|not clearly below|below) the [\d.]+ m of its start", line)
    verdict = r"(beats|does not clearly beat|does NOT beat) the [\d.]+ m of"
    assert re.search(rf"and it {verdict} the rule orthogonal( and |$)", line)
    assert re.search(rf"and (it )?{verdict} the (rule orthogonal|best scripted policy (orca|mvp|cbf|mpc|qmdp))$", line)
