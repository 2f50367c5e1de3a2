"""The package as it is installed: what the wheel holds, what an import loads, what no file may name."""

import fnmatch
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MAPPED = ("baselines", "eval", "train")  # folders at the top whose import name is rss_gym.<folder>
LINKS = [ROOT / "rss_gym" / folder for folder in MAPPED]
HEAVY = {
    "numba",
    "llvmlite",
    "scipy",
    "torch",
    "stable_baselines3",
    "sb3_contrib",
    "pygame",
    "matplotlib",
    "moviepy",
    "highway_env",
}
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]


def import_name(folder: Path) -> str:
    """rss_gym/physics -> rss_gym.physics, eval/metrics -> rss_gym.eval.metrics."""
    parts = folder.relative_to(ROOT).parts
    return ".".join(parts if parts[0] == "rss_gym" else ("rss_gym", *parts))


def source_files(pattern: str = "*") -> list[Path]:
    """Files below the package folders, each once: links, or the files that stand for them, are left out."""
    found = [p for top in ("rss_gym", *MAPPED) for p in (ROOT / top).rglob(pattern)]
    return [p for p in found if p.is_file() and "__pycache__" not in p.parts and p not in LINKS]


def repository_files() -> list[Path]:
    """Files that Git holds or would add."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listing.returncode != 0:
        pytest.skip("not a Git checkout")
    return [ROOT / name for name in listing.stdout.split("\0") if name and (ROOT / name).is_file()]


def test_packages_are_the_folders_with_init() -> None:
    folders = {import_name(init.parent) for init in source_files("__init__.py")}
    assert sorted(SETUPTOOLS["packages"]) == sorted(folders)


def test_no_module_lies_outside_a_package() -> None:
    assert [str(p) for p in source_files("*.py") if not (p.parent / "__init__.py").is_file()] == []


def test_mapped_folders() -> None:
    assert SETUPTOOLS["package-dir"] == {f"rss_gym.{folder}": folder for folder in MAPPED}


@pytest.mark.parametrize("link", LINKS, ids=lambda link: link.name)
def test_link(link: Path) -> None:
    if link.is_file():
        pytest.skip("checkout without symbolic links (core.symlinks=false)")
    assert link.is_symlink()
    assert link.readlink().as_posix() == f"../{link.name}"
    assert link.resolve() == ROOT / link.name


def test_data_files_are_in_the_wheel() -> None:
    packages = {import_name(init.parent) for init in source_files("__init__.py")}
    missing = []
    for path in source_files():
        if path.suffix == ".py":
            continue
        owner = next(parent for parent in path.parents if import_name(parent) in packages)
        patterns = SETUPTOOLS["package-data"].get(import_name(owner), [])
        if not any(fnmatch.fnmatch(path.relative_to(owner).as_posix(), pattern) for pattern in patterns):
            missing.append(path.relative_to(ROOT).as_posix())
    assert missing == [], "not matched by a pattern of [tool.setuptools.package-data]"


def test_no_file_names_a_registry_or_a_machine() -> None:
    # Written in pieces, so that this file does not match itself.
    hosts = "|".join(rf"{name}\.org" for name in ("pypi", "pythonhosted", "pytorch"))
    folders = "|".join(("home", "opt", "root", "tmp", "work", "Users"))
    forbidden = re.compile(rf"{hosts}|(?<![\w.~)}}\]-])/(?:{folders})/[\w.]")
    found = []
    for path in repository_files():
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(text.splitlines(), start=1):
            if forbidden.search(line):
                found.append(f"{path.relative_to(ROOT).as_posix()}:{number}: {line.strip()[:120]}")
    assert found == []


def modules_after(code: str, tmp_path: Path) -> set[str]:
    """Names of the top-level modules that a new process has loaded after `code`, run outside the repository."""
    shown = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys\nprint(*sorted({{m.partition('.')[0] for m in sys.modules}}))"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(shown.stdout.split())


@pytest.mark.parametrize("code", ["import rss_gym", "import rss_gym; rss_gym.__version__"])
def test_import_loads_nothing_heavy(code: str, tmp_path: Path) -> None:
    assert modules_after(code, tmp_path) & HEAVY == set()
