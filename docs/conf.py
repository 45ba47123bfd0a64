"""Sphinx configuration of the documentation site: static, offline, with cells that run."""

from __future__ import annotations

import os
import re
from importlib.metadata import version as version_of
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

LOG = logging.getLogger(__name__)

os.environ["KINOLAB_SOLUTIONS"] = "1"  # a wrong solution is an error of the cell that has it

project, author = "kinolab", "kinolab"
version = release = version_of("kinolab")

extensions = ["myst_nb"]
html_theme = "furo"
html_title = "kinolab"
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["course.css"]
templates_path: list[str] = []
exclude_patterns = ["static"]

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

nb_execution_mode = "cache"  # by content: a chapter runs again where its cells have changed
nb_execution_timeout = 300  # [s] for each cell
nb_execution_raise_on_error = True
nb_code_prompt_show = "Show the {type}"
nb_code_prompt_hide = "Hide the {type}"
nb_merge_streams = True


def _mathml(node: nodes.Element, text: str, *, block: bool) -> str:
    try:
        return str(tex2mathml(text.replace(r"\dots", r"\ldots"), as_block=block))
    except MathError as error:
        LOG.warning("formula %r: %s", text, error, location=node)
        return ""


def _inline(self: Any, node: nodes.math) -> None:
    self.body.append(_mathml(node, node.astext(), block=False))
    raise nodes.SkipNode


def _block(self: Any, node: nodes.math_block) -> None:
    for text in re.split(r"\n\n|\$\$\s*\$\$", node.astext()):  # several formulas of one cell
        self.body.append(f'<div class="math-block">{_mathml(node, text, block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Write formulas as MathML, which every browser draws without a script or a network."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
