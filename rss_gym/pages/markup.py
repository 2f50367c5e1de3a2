"""Markup of templates: whatever a template is given is escaped, unless it is markup already.

A template is a file in a folder `templates` beside the module that fills it in. It may use the templates of this
package and the filters below; a name that it is not given is an error.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from rss_gym.pages.numbers import MINUS, figures, number

FOLDER = Path(__file__).parent / "templates"


def renderer(module: str) -> Callable[..., Markup]:
    """The function that fills in the templates beside a module: `render = renderer(__file__)`, `render("x.html", a=1)`.

    Parameters
    ----------
    module : str
        Path of the module.
    """
    folder = Path(module).parent / "templates"

    def render(template: str, /, **values: object) -> Markup:
        return Markup(_environment(folder).get_template(template).render(values))

    return render


def breaks(name: object) -> Markup:
    """A long name that may be broken behind its colons and commas."""
    return Markup(re.sub("[:,]", r"\g<0><wbr>", str(escape(name))))


def minus(shown: str) -> str:
    """A number with a minus sign in place of a hyphen in front."""
    return re.sub("^-", MINUS, shown)


@cache
def _environment(folder: Path) -> Environment:
    environment = Environment(
        loader=FileSystemLoader([folder, FOLDER]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"breaks": breaks, "minus": minus, "number": number, "figure": figures}
    return environment
