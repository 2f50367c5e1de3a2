"""The site, built by `make docs` into build/docs."""

import os
import sys
from pathlib import Path

# Kernels as plain functions, so that their signatures and docstrings are read. Numba reads this when it is imported;
# the notebooks run in processes of their own, which compile.
os.environ["NUMBA_DISABLE_JIT"] = "1"
import numba  # noqa: F401

del os.environ["NUMBA_DISABLE_JIT"]

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent))
os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE.parent), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)

from sphinx_gallery.sorting import ExplicitOrder  # noqa: E402

import rss_gym  # noqa: E402

project = "rss_gym"
author = "rss_gym contributors"
project_copyright = "rss_gym contributors, MIT licence"
version = release = rss_gym.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "extensions.generated",
    "extensions.equations",
    "extensions.mathml",
    "extensions.commands",
    "extensions.links",
]
exclude_patterns = ["_templates", "extensions", "**/.ipynb_checkpoints", "gallery/*.ipynb", "gallery/*.py"]
templates_path = ["_templates"]
default_role = "code"
suppress_warnings = [
    "toc.not_included",  # a page that nobody has put into a list yet is no fault of the others
    "mystnb.unknown_mime_type",
]

autosummary_generate = True
autodoc_typehints = "none"  # the docstrings say it
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True

GALLERY = [
    f"{name}.py"
    for name in ("signal_strength", "estimators", "range_of_an_encounter", "zones", "two_policies", "front")
]
# Scripts run in processes of their own, where kernels are compiled: this one has them as plain functions.
sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": ExplicitOrder(GALLERY),
    "parallel": 2,
    "abort_on_example_error": True,
    "image_srcset": ["2x"],
    "thumbnail_size": (400, 240),
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
}

html_theme = "pydata_sphinx_theme"
html_math_renderer = "mathml"
html_title = "rss_gym"
html_static_path = ["_static"]
html_css_files = ["site.css"]
# Pages that have no others beside them need no list of those.
_ALONE = (
    "quickstart",
    "tutorial",
    "concepts",
    "theory",
    "parameters",
    "comparison",
    "faq",
    "changelog",
    "contributing",
    "cite",
)
html_sidebars: dict[str, list[str]] = {name: [] for name in _ALONE}
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 6,
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_context = {"default_mode": "auto"}
