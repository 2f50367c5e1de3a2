"""The README's Python runs as written, and what it quotes is what it quotes."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
QUOTED = re.search(r"<!-- sb3 -->\n```python\n(.*?)```\n<!-- /sb3 -->", README, re.DOTALL)
BLOCKS = re.findall(r"```python\n(.*?)```", README.replace(QUOTED[0], ""), re.DOTALL)


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_block_runs(number, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[number], f"README.md, block {number}", "exec"), {"__name__": "readme"})
    assert capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_the_training_is_that_of_the_example():
    """`tests/test_examples.py` runs it; `rss-gym study readme` copies it anew."""
    example = (ROOT / "examples" / "sb3_ppo.py").read_text(encoding="utf-8")
    assert example.endswith(f'"""\n\n{QUOTED[1]}')
