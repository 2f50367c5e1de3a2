"""The page that every command writes: one file that needs no network, from sections of markup and data.

Markup is trusted, so whatever comes from outside goes through `text` first; data may hold anything.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Any

FOLDER = Path(__file__).parent
SORTING = FOLDER / "tables.js"
# In a script element these could end it, open a comment, or (the last two) break a line of an old parser's string.
_UNSAFE = {ord(character): f"\\u{ord(character):04x}" for character in "<>&\u2028\u2029"}


@dataclass(frozen=True)
class Section:
    """One part of the page, with an entry in its contents.

    Parameters
    ----------
    title : str
        Plain text; the anchor is made from it.
    markup : str
        HTML.
    data : optional
        JSON for a script, which finds it by the id `data-<anchor>`.
    """

    title: str
    markup: str
    data: Any = None

    @property
    def anchor(self) -> str:
        """Id of the section."""
        return re.sub("[^a-z0-9]+", "-", self.title.lower()).strip("-")


def text(value: object) -> str:
    """Plain text as markup, inside an element or a quoted attribute."""
    return html.escape(str(value), quote=True)


def embedded(value: Any) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":")).translate(_UNSAFE)


def render(title: str, lead: str, sections: Sequence[Section], scripts: Sequence[Path] = (SORTING,)) -> str:
    """The page.

    Parameters
    ----------
    title : str
        Plain text.
    lead : str
        Markup under the title.
    sections : sequence of Section
    scripts : sequence of Path
        Run after the page has been read.
    """
    code = "".join(script.read_text(encoding="utf-8") for script in scripts)
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    template = Template((FOLDER / "template.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=text(title),
        # Nothing is fetched, and no script runs but the one below.
        policy=f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; base-uri 'none'",
        style=(FOLDER / "style.css").read_text(encoding="utf-8"),
        lead=lead,
        contents="".join(f'<a href="#{section.anchor}">{text(section.title)}</a>' for section in sections),
        sections="".join(_markup(section) for section in sections),
        script=code,
    )


def _markup(section: Section) -> str:
    data = ""
    if section.data is not None:
        data = f'<script type="application/json" id="data-{section.anchor}">{embedded(section.data)}</script>\n'
    return f'<section id="{section.anchor}">\n<h2>{text(section.title)}</h2>\n{section.markup}\n{data}</section>\n'
