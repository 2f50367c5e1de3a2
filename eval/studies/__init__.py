"""Studies: what the product claims of its world, flown and printed by `rss-gym study NAME`.

A new study is one package with `run(scale)`, an iterator of sections, and one line in `STUDIES`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from rss_gym.eval.studies import world
from rss_gym.eval.studies.section import Scale, Section

STUDIES: dict[str, Callable[[Scale], Iterator[Section]]] = {"world": world.run}


def page(name: str, sections: Sequence[Section]) -> str:
    """The sections of a study as a page of Markdown."""
    command = f"Made by `rss-gym study {name} --out docs/{name}.md`, which flies all of it anew."
    return "\n".join([f"# Study: {name}", "", command, "", *(section.markdown for section in sections)])
