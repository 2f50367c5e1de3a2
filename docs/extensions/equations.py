"""The equations of the paper and the functions whose docstrings name them, in both directions."""

from __future__ import annotations

import ast
import functools
import importlib
import re
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parent.parent.parent
PACKAGES = ("physics", "radio", "ranging", "positioning", "safety", "avoidance")
LAST = 45
# A number in brackets, or a range of such, that is not the argument of a function and not the number of another source.
NUMBER = re.compile(r"(?<![\w)^])(?<!equation )\((\d{1,2})\)(?:-\((\d{1,2})\))?")


@functools.cache
def named() -> dict[int, list[str]]:
    """Number of an equation -> the public functions and classes that name it; the module where none does."""
    whole: dict[int, list[str]] = {number: [] for number in range(1, LAST + 1)}
    for package in PACKAGES:
        for file in sorted((ROOT / "rss_gym" / package).glob("*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            stem = f"rss_gym.{package}" + ("" if file.stem == "__init__" else f".{file.stem}")
            own: dict[int, list[str]] = {}
            for node in tree.body:
                if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                    for number in numbers(ast.get_docstring(node) or ""):
                        own.setdefault(number, []).append(public(stem, node.name))
            for number in numbers(ast.get_docstring(tree) or ""):
                if file.stem != "__init__":
                    own.setdefault(number, [stem])
            for number, names in own.items():
                whole[number] += names
    return whole


def numbers(text: str) -> list[int]:
    """The equations that a docstring names."""
    found: set[int] = set()
    for first, last in NUMBER.findall(text):
        found.update(range(int(first), int(last or first) + 1))
    return sorted(number for number in found if 1 <= number <= LAST)


def public(module: str, name: str) -> str:
    """The shortest name: that of the package if it hands the function out."""
    package = module.rpartition(".")[0]
    if package.count(".") == 1 and name in getattr(importlib.import_module(package), "__all__", ()):
        return f"{package}.{name}"
    return f"{module}.{name}"


def functions(number: str) -> str:
    """A line of Markdown that links the functions of an equation."""
    names = named()[int(number)]
    links = (f"{{py:mod}}`~{name}`" if is_module(name) else f"{{py:obj}}`~{name}`" for name in names)
    return f"In code: {', '.join(links)}" if names else "No function has this number."


def is_module(name: str) -> bool:
    """Whether a name is that of a file."""
    return ROOT.joinpath(*name.split(".")).with_suffix(".py").is_file()


def link(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Make the numbers in a docstring links to the page of the theory, and its signs plain text."""
    paper = name.startswith(tuple(f"rss_gym.{package}" for package in PACKAGES))
    for index, line in enumerate(lines):
        if line.lstrip().startswith(("..", ">>>")):
            continue
        pieces = re.split(r"(`[^`]*`)", line)
        for at in range(0, len(pieces), 2):
            plain = re.sub(r"(?<!\*)\*(?!\*)|\|", lambda sign: "\\" + sign[0], pieces[at])
            plain = re.sub(r"(?<=\w)_(?!\w)", r"\\_", plain)
            pieces[at] = NUMBER.sub(linked, plain) if paper else plain
        lines[index] = "".join(pieces)


def linked(match: re.Match[str]) -> str:
    """A number or a range of them, each end a link."""
    ends = [end for end in match.groups() if end]
    if not all(1 <= int(end) <= LAST for end in ends):
        return match[0]
    return "-".join(f":ref:`({end}) <eq-{end}>`" for end in ends)


def setup(app: Sphinx) -> dict[str, bool]:
    """For Sphinx; after numpydoc, which reads the plain text."""
    app.connect("autodoc-process-docstring", link, priority=900)
    return {"parallel_read_safe": True}
