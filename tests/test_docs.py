"""What the documents and pyproject.toml name exists."""

import fnmatch
import importlib
import re
import tomllib
from pathlib import Path

import pytest

from rss_gym import baselines
from rss_gym.cli import parser
from rss_gym.domain import ROAD
from rss_gym.eval.suites import SUITES
from rss_gym.ids import IDS, ROADS
from rss_gym.listing import parameters
from rss_gym.observation import fields
from rss_gym.params import Params
from rss_gym.registry import GROUP
from rss_gym.train.recipe import recipes

ROOT = Path(__file__).resolve().parent.parent
SITE = sorted(path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.relative_to(ROOT).parts)
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *SITE]
# Pages whose code runs here as it stands, page by page; the code of others is compiled.
RUN = ("quickstart", "concepts", "parameters", "own-policy", "library", "tutorial")
FOLDERS = "rss_gym|baselines|train|eval|tests|docs|examples|benchmarks"


def text_of(page):
    return page.read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", re.sub(r"```md\n.*?```", "", text_of(page), flags=re.DOTALL))
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
    assert page.name != "scores.md" or named >= {name for name, suite in SUITES.items() if suite.domain is not ROAD}


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


def code(page):
    return re.findall(r"```(?:python|\{code-cell\} python)\n(.*?)```", text_of(page), re.DOTALL)


@pytest.mark.parametrize("page", [page for page in PAGES if code(page)], ids=lambda page: page.name)
def test_code_compiles(page):
    for number, block in enumerate(code(page)):
        compile(block, f"{page.name}, block {number}", "exec")


@pytest.mark.parametrize("name", RUN)
def test_code_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": name}
    for block in code(ROOT / "docs" / f"{name}.md"):
        # A test has no need of as many encounters.
        exec(compile(block.replace("episodes=2000", "episodes=50"), f"{name}.md", "exec"), names)
    assert capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def site(monkeypatch):
    """The module that makes parts of pages of the code."""
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    return importlib.import_module("extensions.generated")


def test_every_environment_has_a_card_with_all_its_columns(site):
    marks = [found for page in SITE for found in site.MARK.findall(text_of(page))]
    assert sorted(name for kind, name in marks if kind == "card") == sorted([*IDS, *ROADS])
    assert {kind for kind, _ in marks} == set(site.KINDS)
    assert [group for kind, group in marks if kind == "parameters"] == [
        *dict.fromkeys(p["group"] for p in parameters())
    ]
    for name, keywords in IDS.items():
        columns = [field.name for field in fields(Params.of(**keywords))]
        text = site.card(name)
        assert re.findall(r"^\| \d+ \| `([a-z]\w+(?:\.\w+)?)`", text, re.MULTILINE) == columns
        assert "## Version history" in text


def test_every_equation_is_on_the_page_of_the_theory_and_has_its_functions(site):
    theory = text_of(ROOT / "docs" / "theory.md")
    numbers = [int(number) for number in re.findall(r"^\(eq-(\d+)\)=$", theory, re.MULTILINE)]
    assert numbers == list(range(1, site.equations.LAST + 1))
    assert [number for number in numbers if not site.equations.named()[number]] == [41]
    assert "rss_gym.safety.radius_m" in site.equations.named()[40]


def test_a_broken_link_of_the_site_is_found(site, tmp_path):
    links = importlib.import_module("extensions.links")
    (tmp_path / "a.html").write_text('<a href="b.html#here">b</a><a href="c.html">c</a>', encoding="utf-8")
    (tmp_path / "b.html").write_text('<p id="there"></p><img src="https://example.org/x.png">', encoding="utf-8")
    assert links.broken(tmp_path) == [
        "a.html links to b.html#here, an anchor that does not exist",
        "a.html links to c.html, which does not exist",
        "b.html loads https://example.org/x.png",
    ]


def test_commands_that_install_work_before_a_release():
    extras = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]["optional-dependencies"]
    folders = ("rss_gym", "baselines", "train", "eval", "examples", "docs")
    files = [path for name in folders for kind in ("*.py", "*.md") for path in (ROOT / name).rglob(kind)]
    text = "\n".join(map(text_of, [ROOT / "README.md", ROOT / "CHANGELOG.md", *files]))
    assert re.findall(r"pip install [^\n]*rss-gym\[", text) == []
    named = re.findall(r"pip install -e '\.\[([\w,]+)\]'", text)
    assert len(named) > 10 and {extra for names in named for extra in names.split(",")} <= set(extras)


def test_the_citation_is_of_this_version():
    version = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]["version"]
    citation = text_of(ROOT / "CITATION.cff")
    assert f"\nversion: {version}\n" in citation and re.search(
        r"^date-released: \d{4}-\d\d-\d\d$", citation, re.MULTILINE
    )
    assert f"version = {{{version}}}" in text_of(ROOT / "docs" / "cite.md")
    for number in re.findall(r"^    (?:volume|issue|start|end|doi): (\S+)$", citation, re.MULTILINE):
        assert number in text_of(ROOT / "docs" / "cite.md")


def test_the_entry_for_gymnasium_s_list_names_the_lowest_version():
    gymnasium = next(line for line in text_of(ROOT / "pyproject.toml").splitlines() if '"gymnasium>=' in line)
    lowest = re.search(r">=([\d.]+)", gymnasium)[1]
    assert f"badge/Gymnasium-v{lowest}-blue" in text_of(ROOT / "CONTRIBUTING.md")


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
