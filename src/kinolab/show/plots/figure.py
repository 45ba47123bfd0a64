"""Common style of plots, and their output as files."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Format: TypeAlias = Literal["svg", "png"]

PLAN, START, GOAL, LIMIT = "#2a7de1", "#2ca02c", "#d62728", "#9a9a9a"
WIDTH = 7.0  # inches, which fit a page
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "kinolab",  # the same plan gives the same file
    "svg.fonttype": "none",  # text stays text, which can be searched and edited
    "text.parse_math": False,  # a title is of the user's, who may write $5
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
}


def figure_of(
    rows: int, columns: int, size: tuple[float, float], title: str
) -> tuple[Figure, list[Axes]]:
    """Return a figure, width and height in inches, with a table of axes, row by row."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        figure.suptitle(title, parse_math=False, usetex=False)  # a title is no formula
    return figure, list(axes)


def written(figure: Figure, form: Format) -> bytes:
    """Return a figure as a file."""
    from matplotlib import rc_context

    out = io.BytesIO()
    undated = {"Date": None} if form == "svg" else {}
    with rc_context(STYLE):
        figure.savefig(out, format=form, dpi=150, metadata=undated)  # dots per inch of a PNG
    return out.getvalue()


def label(name: str, unit: str) -> str:
    """Return the label of an axis; dollars in a unit begin no formula."""
    return (f"{name} [{unit}]" if unit else name).replace("$", r"\$")
