"""The README's Python runs as written, and what it quotes is what it quotes."""

import re
from pathlib import Path

import pytest

from rss_gym.eval.studies.opponents.jobs import README as FLOWN
from rss_gym.eval.studies.opponents.page import SHORT

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


def test_it_is_short_and_names_no_equation():
    assert len(README.splitlines()) <= 150
    prose = re.sub(r"```.*?```|`[^`]*`", "", README, flags=re.DOTALL)
    assert re.findall(r"(?<![\w)])\(\d{1,2}\)", prose) == []
    assert (ROOT / "docs" / "img" / "encounter.gif").stat().st_size < 1_000_000


def test_its_table_has_the_columns_of_the_study():
    rows = re.search(r"<!-- scores -->\n(.*?)\n\n", README, re.DOTALL)[1].splitlines()
    titles = [cell.strip() for cell in rows[0].split("|")[1:-1]]
    assert titles == ["policy", *(column.heading for column in SHORT.values())]
    assert {row.split("`")[1] for row in rows[2:]} >= {*FLOWN}
