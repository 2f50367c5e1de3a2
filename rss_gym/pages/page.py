"""The page that every command writes: one file that needs no network, from sections of markup and data.

Text is escaped wherever it stands; markup comes from templates (`rss_gym.pages.markup`) and from figures alone, and
data may hold anything.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from rss_gym.pages.markup import renderer

FOLDER = Path(__file__).parent
SORTING, CANVAS = FOLDER / "tables.js", FOLDER / "canvas.js"
_render = renderer(__file__)
# In a script element these could end it, open a comment, or (the last two) break a line of an old parser's string.
_UNSAFE = {ord(character): f"\\u{ord(character):04x}" for character in "<>&\u2028\u2029"}


@dataclass(frozen=True)
class Section:
    """One part of the page, with an entry in its contents.

    Parameters
    ----------
    title : str
        Plain text; the anchor is made from it.
    content : Markup or str
        Markup; a plain text is shown as such.
    data : optional
        JSON for a script, which finds it by the id `data-<anchor>`.
    """

    title: str
    content: Markup | str
    data: Any = None

    @property
    def anchor(self) -> str:
        """Id of the section."""
        return re.sub("[^a-z0-9]+", "-", self.title.lower()).strip("-")


def style() -> Markup:
    """The style sheet of every page."""
    return Markup((FOLDER / "style.css").read_text(encoding="utf-8"))


def embedded(value: Any) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return Markup(text.translate(_UNSAFE))


def render(title: str, lead: Markup | str, sections: Sequence[Section], scripts: Sequence[Path] = (SORTING,)) -> Markup:
    """The page.

    Parameters
    ----------
    title : str
        Plain text.
    lead : Markup or str
        Under the title.
    sections : sequence of Section
    scripts : sequence of Path
        Run after the page has been read.
    """
    code = "".join(script.read_text(encoding="utf-8") for script in scripts)
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    return _render(
        "page.html", title=title, lead=lead, sections=sections, style=style(), script=Markup(code), digest=digest,
        embedded=embedded,
    )  # fmt: skip
