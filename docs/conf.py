"""Sphinx configuration of the documentation site: static, offline, with cells that run."""

from __future__ import annotations

import os
import re
from importlib.metadata import version as version_of
from importlib.util import find_spec
from pathlib import Path
from runpy import run_path
from typing import Any

from sphinx.util import logging

from kinolab.errors import KinolabError

os.environ["KINOLAB_SOLUTIONS"] = "1"  # a wrong solution is an error of the cell that has it

project, author = "kinolab", "kinolab"
version = release = version_of("kinolab")

# MathJax comes along, so that formulas need no network: the one file that has its fonts, too.
MATHJAX = find_spec("sphinx-mathjax-offline")
assert MATHJAX is not None, "pip install '.[docs]' brings it"

extensions = ["myst_nb"]
mathjax_path = "tex-svg.js"
html_theme = "furo"
html_title = "kinolab"
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_static_path = [
    "static",
    str(Path(str(MATHJAX.origin)).parent / "static" / "mathjax" / "tex-svg.js"),
]
html_css_files = ["course.css"]
templates_path: list[str] = []
exclude_patterns = ["static"]

LOG = logging.getLogger(__name__)
GALLERY = Path(__file__).resolve().parents[1] / "tools" / "write_gallery.py"

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

nb_execution_mode = "cache"  # by content: a chapter runs again where its cells have changed
nb_execution_timeout = 300  # [s] for each cell
nb_execution_raise_on_error = True
nb_execution_show_tb = True  # what went wrong, and in which cell
nb_code_prompt_show = "Show the {type}"
nb_code_prompt_hide = "Hide the {type}"
nb_merge_streams = True


# A formula and what follows it: browsers break lines between a picture and a comma.
FORMULA_AND_MARK = re.compile(
    r'(<span class="math notranslate nohighlight">[^<]*</span>[,.;:?!)’]+)'
)


def _unbroken(_app: Any, _page: str, _template: str, context: dict[str, Any], _: object) -> None:
    """Keep a punctuation mark on the line of the formula that it follows."""
    if "body" in context:
        context["body"] = FORMULA_AND_MARK.sub(r'<span class="unbroken">\1</span>', context["body"])


def _named(_app: Any, _page: str, _template: str, context: dict[str, Any], _: object) -> None:
    """Say what is hidden: nothing but solutions is as a whole cell."""
    if "body" in context:
        for verb in ("Show", "Hide"):
            context["body"] = context["body"].replace(f"{verb} the content", f"{verb} the solution")


def _plans(app: Any) -> None:
    """Write the interactive pages that the films of the gallery lead to, from the kept motions.

    Each motion is verified anew; one that does not solve its scenario is a warning.
    """
    if app.builder.name != "html":
        return
    gallery = run_path(str(GALLERY))
    for name in gallery["kept_plans"]():
        try:
            gallery["write_plan_page"](name, Path(app.outdir))
        except KinolabError as error:
            remedy = f"python tools/write_gallery.py --plans {name} plans it anew"
            LOG.warning("the gallery's plan for %s: %s\n%s", name, error, remedy)


def setup(app: Any) -> None:
    """Connect what this file adds to Sphinx."""
    app.connect("builder-inited", _plans)
    app.connect("html-page-context", _named)
    app.connect("html-page-context", _unbroken)
