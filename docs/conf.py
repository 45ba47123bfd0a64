"""Sphinx configuration of the documentation site: static, offline, with cells that run."""

from __future__ import annotations

import os
from importlib.metadata import version as version_of
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

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


def _inline(self: Any, node: nodes.math) -> None:
    self.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def _block(self: Any, node: nodes.math_block) -> None:
    text = node.astext()
    for line in text.split("\n\n"):
        self.body.append(f'<div class="math-block">{tex2mathml(line, as_block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Write formulas as MathML, which every browser draws without a script or a network."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
