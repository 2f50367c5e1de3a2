"""Every link within the site leads to a file and an anchor that exist; nothing is loaded from elsewhere."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


class Page(HTMLParser):
    """The links, loads and anchors of a page."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.loads: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what the tag refers to."""
        values = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := values.get(key))}
        if href := values.get("href"):
            (self.links if tag == "a" else self.loads).add(href)
        if src := values.get("src"):
            self.loads.add(src)


def broken(folder: Path) -> list[str]:
    """A sentence for each broken link, and for each load from another place."""
    files = [file for file in folder.rglob("*.html") if "_static" not in file.relative_to(folder).parts]
    pages = {file.resolve(): Page(file) for file in files}
    found = []
    for file, page in sorted(pages.items()):
        where = file.relative_to(folder.resolve()).as_posix()
        found += [f"{where} loads {load}" for load in sorted(page.loads) if urlsplit(load).netloc]
        for link in sorted(page.links | page.loads):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if not target.exists():
                found.append(f"{where} links to {link}, which does not exist")
            elif target in pages and parts.fragment and unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{where} links to {link}, an anchor that does not exist")
    return found


def check(app: Sphinx, exception: Exception | None) -> None:
    """Fail the build if a link is broken."""
    if exception is None and app.builder.format == "html" and (found := broken(Path(app.outdir))):
        raise ExtensionError("\n".join(found))


def setup(app: Sphinx) -> dict[str, bool]:
    """For Sphinx."""
    app.connect("build-finished", check)
    return {"parallel_read_safe": True}
