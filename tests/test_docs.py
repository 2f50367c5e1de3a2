"""What the documents and pyproject.toml name exists."""

import fnmatch
import re
import tomllib
from pathlib import Path

import pytest

from rss_gym import baselines
from rss_gym.cli import parser
from rss_gym.domain import ROAD
from rss_gym.eval.suites import SUITES
from rss_gym.ids import IDS, ROADS
from rss_gym.params import Params
from rss_gym.registry import GROUP
from rss_gym.train.recipe import recipes

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md")] + sorted((ROOT / "docs").glob("*.md"))
FOLDERS = "rss_gym|baselines|train|eval|tests|docs|examples|benchmarks"


def text_of(page):
    return page.read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", text_of(page))
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_and_modules_exist(page):
    code = "\n".join(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)))
    paths = re.findall(rf"(?<![\w./])((?:{FOLDERS})/[\w./*-]*)", code)
    # Ids look like paths, and where a name in capitals stands, anything may.
    paths = [path for path in paths if not re.search(r"[A-Z]{4}|-v\d$", path)]
    assert [path for path in paths if not list(ROOT.glob(path.rstrip("/.")))] == []
    modules = re.findall(r"(?<![\w./])rss_gym(?:\.[a-z_]\w*)+", code)
    assert [name for name in modules if name != GROUP and not exists(name)] == []


def exists(name):
    """A module or an attribute of one."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        path = ROOT.joinpath(*parts[:length])
        if path.is_dir() or path.with_suffix(".py").is_file():
            rest = parts[length:]
            source = path.with_suffix(".py") if path.with_suffix(".py").is_file() else path / "__init__.py"
            return not rest or re.search(rf"\b{rest[0]}\b", text_of(source)) is not None
    return False


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_ids_and_suites_exist(page):
    content = text_of(page)
    assert set(re.findall(r"\brss_gym/[A-Z]\w*-v\d", content)) <= {*IDS, *ROADS}
    named = set(re.findall(r"`([a-z0-9-]+-v\d)`", content))
    assert named <= set(SUITES)
    assert page.name != "README.md" or named >= {name for name, suite in SUITES.items() if suite.domain is not ROAD}


def commands():
    found = []
    for page in PAGES:
        for block in re.findall(r"```sh\n(.*?)```", text_of(page), re.DOTALL):
            found += [line.partition("#")[0].strip() for line in block.splitlines() if line.startswith("rss-gym ")]
    return sorted(set(found))


@pytest.mark.parametrize("command", commands())
def test_commands_parse(command):
    options = parser().parse_args(command.split()[1:])
    if options.command == "eval" and SUITES[options.suite].domain is not ROAD:
        for spec in options.policy:
            if "/" not in spec:
                baselines.make(spec, Params())
    if options.command == "train" and options.recipe is not None:
        assert options.recipe in recipes()


def test_pyproject_names_modules_that_exist():
    settings = tomllib.loads(text_of(ROOT / "pyproject.toml"))["tool"]
    found = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in (ROOT / "rss_gym").rglob("*.py")}
    for folder in ("baselines", "eval", "train"):
        files = (path.relative_to(ROOT).with_suffix("") for path in (ROOT / folder).rglob("*.py"))
        found |= {"rss_gym." + ".".join(file.parts) for file in files}
    found |= {name.removesuffix(".__init__") for name in found}
    named = [name for item in settings["mypy"]["overrides"] for name in [item["module"]]]
    named = [one for name in named for one in ([name] if isinstance(name, str) else name)]
    for contract in settings["importlinter"]["contracts"]:
        named += contract.get("source_modules", []) + contract.get("forbidden_modules", [])
    ours = [name for name in named if name.startswith("rss_gym.")]
    assert [name for name in ours if not fnmatch.filter(found, name)] == []
