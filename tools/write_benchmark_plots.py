"""Write docs/images/benchmarks/*.svg, plots of the tables in docs/benchmarks.md.

    python tools/write_benchmark_plots.py [--check]

With --check nothing is written: it shows how the files differ and returns 1 if they do. The tables
of the page are the only source of the numbers. Each file has what it plots as JSON in its
description, and each series is a group with the series' name as its id. Another version of
Matplotlib may write other text for the same picture.
"""

from __future__ import annotations

import argparse
import difflib
import io
import itertools
import json
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, FOLDER = DOCS / "benchmarks.md", DOCS / "images" / "benchmarks"

# Both are seen on the site's light background and on its dark one, as is the grey of all text.
OURS, OTHERS, TEXT = "#2a7de1", "#d0731a", "#7a7a7a"
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "kinolab",  # the same table gives the same file
    "svg.fonttype": "none",  # text stays text, which can be searched
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # which is wide: where another one stands in, all fits
    "font.size": 10.0,
    "text.color": TEXT,
    "axes.edgecolor": TEXT,
    "axes.labelcolor": TEXT,
    "axes.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": TEXT,
    "ytick.color": TEXT,
    "legend.frameon": False,
    "legend.handletextpad": 0.3,
    "legend.columnspacing": 1.2,
    "legend.borderaxespad": 0.0,
    "legend.borderpad": 0.0,
}
WIDTH = 360.0  # [pt], 480 pixels: a telephone shows them at three quarters of that
LINE = 11.5  # [pt] from one line of text to the next
SHADES = ((207, 225, 247), (18, 63, 128))  # of the fastest and of the slowest search

Numbers: TypeAlias = list[float | None]


@dataclass(frozen=True)
class Table:
    """A table of the page: the paragraph above it, its headings, and its cells by heading."""

    lead: str
    headings: list[
        str
    ]  # one that comes twice is told apart by the one on its left: "f [ns]: limit"
    rows: list[dict[str, str]]


@dataclass(frozen=True)
class Chart:
    """What a figure plots.

    Attributes:
        rows: A label for each value of a series, in the table's order.
        series: Values by name; None where the table has none.
        notes: Further text of each row, such as a time in seconds; none or one for each.
        groups: Title of the group that each row belongs to, if they are grouped.
        constants: Further numbers: limits and sizes of samples.
    """

    rows: list[str]
    series: dict[str, Numbers]
    notes: list[str] = field(default_factory=list)
    groups: list[str] = field(default_factory=list)
    constants: dict[str, float] = field(default_factory=dict)

    @property
    def description(self) -> str:
        """The numbers as JSON."""
        numbers = {"rows": self.rows, "series": self.series, "constants": self.constants}
        return json.dumps(numbers, ensure_ascii=False)


def tables(page: str, heading: str, *columns: str) -> list[Table]:
    """Return the tables of a section, subsections included, that have all those columns.

    Raises:
        LookupError: If there is none: the page and this script must be changed together.
    """
    section = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    paragraphs = [text for text in (section[1] if section else "").split("\n\n") if text.strip()]
    found = [
        table_of(lead, text)
        for lead, text in zip(["", *paragraphs], paragraphs, strict=False)
        if text.lstrip().startswith("|")
    ]
    wanted = [table for table in found if set(columns) <= set(table.headings)]
    if not wanted:
        raise LookupError(f"no table with {', '.join(columns)} below “{heading}” in {PAGE.name}")
    return wanted


def table_of(lead: str, text: str) -> Table:
    """Return a table as it is written in Markdown."""
    lines = [line.strip().strip("|") for line in text.strip().splitlines()]
    headings, _, *rows = ([cell.strip() for cell in line.split("|")] for line in lines)
    unique = [
        name if headings.count(name) == 1 else f"{headings[index - 1]}: {name}"
        for index, name in enumerate(headings)
    ]
    cells = [dict(zip(unique, row, strict=True)) for row in rows]
    return Table(" ".join(lead.split()), unique, cells)


def number(text: str) -> float | None:
    """Return the first number of a text, without the commas between thousands; None without.

    Raises:
        ValueError: If it is only a bound, which a mark like the others would hide.
    """
    if "≥" in text:
        raise ValueError(f"“{text}” is only a bound, which the plot cannot say")
    found = re.search(r"[-+]?\d[\d,]*(\.\d+)?(e[-+]?\d+)?", text)
    return float(found[0].replace(",", "")) if found else None


def sure(text: str) -> float:
    """Return the first number of a text that must have one."""
    value = number(text)
    if value is None:
        raise ValueError(f"there is no number in “{text}”")
    return value


def ratio(value: float | None, of: float | None) -> float | None:
    """Return a quotient, to six digits, where both numbers are known."""
    return float(f"{value / of:.6g}") if value is not None and of else None


def waiting(page: str) -> Chart:
    """Read how many times as long commands and their motions took with the version before."""
    found = tables(page, "What somebody waits for", "command", "end", "motion")
    cells = [(table.lead.rstrip(":"), row) for table in found for row in table.rows]
    names = [row["command"].strip("`") for _, row in cells]
    return Chart(
        rows=[short_command(name) for name in names],
        series={key: [in_brackets(row[key]) for _, row in cells] for key in ("end", "motion")},
        notes=[f"{row['end'].split()[0]} s" for _, row in cells],
        groups=[lead for lead, _ in cells],
    )


def in_brackets(cell: str) -> float | None:
    """Return 1.3 of ``27.73 (1.3)``."""
    _, _, ratios = cell.partition("(")
    return number(ratios)


def short_command(name: str) -> str:
    """Return a command without the words that most of them have."""
    return re.sub(r"^plan (?=\w)|^python -c | as found$", "", name)


def draw_waiting(chart: Chart) -> Figure:
    """Draw a dot for each command, and one for its motion."""
    places = list(spaced(chart.groups))
    left, right = 155.0, 305.0
    figure, (axes,) = panels([(left, right)], height=16.0 * (places[-1] + 1.4), top=40.0)
    name_rows(axes, places, chart.rows)
    axes.set_ylim(places[-1] + 0.7, places[0] - 1.7)  # room for the first title
    beside(axes, places, chart.notes, "now", WIDTH - 6.0 - right)
    for title in dict.fromkeys(chart.groups):
        above = places[chart.groups.index(title)] - 1.2
        write(axes, title, (0.0, above), (4.0 - left, 0.0), "left")
    log_axis(axes, [0.5, 1, 2, 4, 8], (0.5, 10.5), "times as long with ac4082d,\nlog scale")
    line_at_one(axes, "one", places, chart.groups)
    dots(axes, "end", chart.series["end"], places, OURS, "until the end")
    dots(axes, "motion", chart.series["motion"], places, OTHERS, "length of the motion", "D")
    legend(figure, axes, columns=2, above=18.0)
    return figure


def equations(page: str) -> Chart:
    """Read how long a state derivative takes."""
    heading = "From definition to compiled equations of motion"
    found = tables(page, heading, "machine", "f [ns]", "Pinocchio [ns]")
    cells = [(re.search(r"load [\d.]+", table.lead), row) for table in found for row in table.rows]
    columns = {"f": "f [ns]", "Pinocchio": "Pinocchio [ns]", "limit": "f [ns]: limit"}
    return Chart(
        rows=[
            row["machine"].replace(", ", ",\n") + (f"\n({load[0]})" if load else "")
            for load, row in cells
        ],
        series={key: [number(row[column]) for _, row in cells] for key, column in columns.items()},
    )


def draw_equations(chart: Chart) -> Figure:
    """Draw three marks for each machine."""
    places = [float(index) for index in range(len(chart.rows))]
    figure, (axes,) = panels([(125.0, 340.0)], height=40.0 * len(places), top=26.0)
    name_rows(axes, places, chart.rows)
    log_axis(axes, [100, 1000, 10000], (50, 20000), "one state derivative [ns], log scale")
    dots(axes, "f", chart.series["f"], places, OURS, "kinolab's f")
    dots(
        axes, "Pinocchio", chart.series["Pinocchio"], places, OTHERS, "Pinocchio, from Python", "D"
    )
    marks(axes, "limit", chart.series["limit"], places, "limit")
    legend(figure, axes, columns=3)
    return figure


def matrix(page: str) -> Chart:
    """Read the median times of planners' searches, a series for each scenario."""
    found = tables(page, "The matrix: planners against scenarios", "planner")
    rows = [row for table in found for row in table.rows]
    scenarios = sorted({name for row in rows for name in row} - {"planner"})
    return Chart(
        rows=[row["planner"] for row in rows],
        series={name: [median_of(row.get(name, "")) for row in rows] for name in scenarios},
        constants={"seeds": seeds_of(rows, scenarios)},
    )


def median_of(cell: str) -> float | None:
    """Return 2.8 of ``5/5, 2.8 s, 26 s``.

    Raises:
        ValueError: If not every run was solved: a median with limits in it needs a mark.
    """
    if not cell:
        return None
    solved, median, _ = cell.split(", ")
    if len(set(solved.split("/"))) != 1:
        raise ValueError(f"{cell}: not every run was solved, which the plot cannot say")
    return sure(median)


def seeds_of(rows: Sequence[dict[str, str]], scenarios: Sequence[str]) -> float:
    """Return how many seeds each cell has, which must be the same for all."""
    cells = [row[name] for row in rows for name in scenarios if row.get(name)]
    (seeds,) = {sure(cell) for cell in cells}
    return seeds


def draw_matrix(chart: Chart) -> Figure:
    """Draw a field for each planner and scenario, the darker the slower."""
    columns, rows = len(chart.series), len(chart.rows)
    height = 24.0 * rows
    figure, (axes,) = panels([(96.0, 350.0)], height=height, top=24.0, bottom=86.0)
    axes.set(xlim=(-0.5, columns - 0.5))
    name_rows(axes, [float(index) for index in range(rows)], chart.rows, lines=False)
    axes.set_xticks(
        range(columns),
        list(chart.series),
        rotation=40,
        ha="right",
        rotation_mode="anchor",
        size=9.0,
    )
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    known = [value for values in chart.series.values() for value in values if value is not None]
    for column, values in enumerate(chart.series.values()):
        for row, value in enumerate(values):
            if value is not None:
                part = math.log(value / min(known)) / math.log(max(known) / min(known))
                shaded(axes, column, row, part, f"{value:.1f}")
    title = f"search, median of {chart.constants['seeds']:g} seeds [s], shaded on a log scale"
    write(axes, title, (0.0, -0.5), (-92.0, 11.0), "left")
    return figure


def shaded(axes: Axes, column: int, row: int, part: float, text: str) -> None:
    """Draw a field with a text that is seen on it; part is 0 for the fastest, 1 for the slowest."""
    red, green, blue = ((a + (b - a) * part) / 255.0 for a, b in zip(*SHADES, strict=True))
    shape = Rectangle((column - 0.48, row - 0.46), 0.96, 0.92, facecolor=(red, green, blue))
    axes.add_patch(shape)
    ink = "#000000" if part < 0.65 else "#ffffff"  # where both have the same contrast
    axes.text(column, row, text, ha="center", va="center_baseline", color=ink)


def ompl(page: str) -> Chart:
    """Read how many times as long OMPL's planners take."""
    (found,) = tables(page, "Beside OMPL in C++", "compared", "ratio", "95 % interval", "target")
    ends = [row["95 % interval"].split(" to ") for row in found.rows]
    medians = [(row["OMPL, median [s]"], row["kinolab, median [s]"]) for row in found.rows]
    names = [tuple(text.split()[0] for text in pair) for pair in medians]
    solved = [(row["OMPL solved"], row["kinolab solved"]) for row in found.rows]
    (seeds,) = {text.split("/")[1] for pair in solved for text in pair}
    return Chart(
        rows=[
            f"{row['problem']}: {row['compared'].partition(',')[0]}\n"
            + (row["compared"].partition(", ")[2] or " against ".join(pair))
            for row, pair in zip(found.rows, names, strict=True)
        ],
        series={
            "ratio": [number(row["ratio"]) for row in found.rows],
            "lower": [number(lower) for lower, _ in ends],
            "upper": [number(upper) for _, upper in ends],
            "target": [number(row["target"]) for row in found.rows],
        },
        notes=[" : ".join(text.split("/")[0] for text in pair) for pair in solved],
        constants={"seeds": sure(seeds)},
    )


def draw_ompl(chart: Chart) -> Figure:
    """Draw a dot with its interval and a target for each pair of planners."""
    places = [float(index) for index in range(len(chart.rows))]
    right = 294.0
    figure, (axes,) = panels([(166.0, right)], height=36.0 * len(places), top=42.0)
    name_rows(axes, places, chart.rows)
    title = f"solved of\n{chart.constants['seeds']:g} each"
    beside(axes, places, chart.notes, title, WIDTH - 4.0 - right)
    log_axis(axes, [1, 2, 4, 8], (0.8, 12.0), "time, OMPL / kinolab,\nlog scale")
    line_at_one(axes, "one", places)
    ends = {key: known_points(chart.series[key], places) for key in ("lower", "upper")}
    axes.hlines(places, ends["lower"][0], ends["upper"][0], OURS, lw=1.5)
    for key, points in ends.items():
        axes.plot(*points, ls="", marker="|", ms=8.0, mew=1.5, color=OURS, gid=key)
    dots(
        axes,
        "ratio",
        chart.series["ratio"],
        places,
        OURS,
        "ratio of medians, 95 % interval",
        size=5,
    )
    marks(axes, "target", chart.series["target"], places, "target")
    legend(figure, axes)
    return figure


def dynobench(page: str) -> Chart:
    """Read costs over the best published ones, and times over those published of iDb-A*."""
    (found,) = tables(page, "The problems of dynobench", "problem", "final [s]", "iDb-A*")
    costs = [(number(row["final [s]"]), number(row["best [s]"])) for row in found.rows]
    theirs = [[number(part) for part in row["iDb-A*"].split(", ")] for row in found.rows]
    return Chart(
        rows=[row["problem"].partition("/")[2] for row in found.rows],
        series={
            "cost": [ratio(final, best) for final, best in costs],
            "cost-iDb-A": [
                ratio(row[3] if len(row) > 3 else None, best)
                for row, (_, best) in zip(theirs, costs, strict=True)
            ],
            "time": [
                ratio(number(row["time [s]"]), other[1])
                for row, other in zip(found.rows, theirs, strict=True)
            ],
        },
        groups=[row["problem"].partition("/")[0] for row in found.rows],
    )


def draw_dynobench(chart: Chart) -> Figure:
    """Draw costs on the left and times on the right, a line for each problem."""
    places = list(spaced(chart.groups, 1.2))
    spans = [(88.0, 216.0), (232.0, 350.0)]
    figure, (left, right) = panels(spans, height=8.0 * (places[-1] + 1.0), top=28.0)
    machines = list(dict.fromkeys(chart.groups))
    of_each = [[p for p, name in zip(places, chart.groups, strict=True) if name == machine]
               for machine in machines]  # fmt: skip
    for axes, names in ((left, machines), (right, [""] * len(machines))):
        name_rows(axes, [sum(group) / len(group) for group in of_each], names, lines=False)
        axes.set_ylim(places[-1] + 1.0, places[0] - 1.0)
        for above, below in itertools.pairwise(of_each):
            axes.axhline((above[-1] + below[0]) / 2, color=TEXT, lw=0.4, alpha=0.5)
    log_axis(left, [0.7, 1, 1.4, 2], (0.65, 2.3), "cost / best published,\nlog scale")
    log_axis(
        right, [0.01, 0.1, 1, 10], (0.008, 30), "time to the first motion\n/ iDb-A*'s, log scale"
    )
    line_at_one(left, "one-cost", places)
    line_at_one(right, "one-time", places)
    dots(left, "cost", chart.series["cost"], places, OURS, "kinolab", size=4.5)
    dots(left, "cost-iDb-A", chart.series["cost-iDb-A"], places, OTHERS, "iDb-A*", "D", size=3.5)
    dots(right, "time", chart.series["time"], places, OURS, "", size=4.5)
    legend(figure, left, columns=2)
    write(right, f"{len(places)} problems", (1.0, places[0] - 1.0), (0.0, 10.0), "right")
    return figure


def memory(page: str) -> Chart:
    """Read by how much memory grows in each quarter of the solves."""
    (found,) = tables(page, "Memory: a thousand solves in one process", "by quarters, MB")
    limit = re.search(r"^## Memory.*?The limit is ([\d.]+) MB", page, re.M | re.S)
    if limit is None:
        raise LookupError("the section on memory names no limit")
    (solves,) = {sure(row["solves"]) for row in found.rows}
    quarters = [row["by quarters, MB"].split() for row in found.rows]
    return Chart(
        rows=[row["planner"] for row in found.rows],
        series={f"quarter-{i + 1}": [number(row[i]) for row in quarters] for i in range(4)},
        constants={"limit": float(limit[1]), "solves": solves},
    )


def draw_memory(chart: Chart) -> Figure:
    """Draw four bars for each planner, and the bar that a leak as large as the limit would make."""
    figure, (axes,) = panels([(42.0, 350.0)], height=150.0, top=14.0)
    level = chart.constants["limit"] / len(chart.series)
    for index, (key, values) in enumerate(chart.series.items()):
        for planner, value in enumerate(values):
            bar = Rectangle((planner + 0.2 * index - 0.39, 0.0), 0.18, value or 0.0, facecolor=OURS)
            bar.set_gid(f"{chart.rows[planner]}-{key}")
            axes.add_patch(bar)
    axes.axhline(level, color=OTHERS, ls="--", lw=1.2, gid="level")
    limit = (
        f"a steady leak of {chart.constants['limit']:g} MB "
        f"in {chart.constants['solves']:g} solves: the limit"
    )
    write(axes, limit, (0.0, level), (4.0, -9.0), "left", OTHERS)
    axes.set_xlim(-0.6, len(chart.rows) - 0.4)
    known = [value for values in chart.series.values() for value in values if value is not None]
    axes.set_ylim(1.1 * min(0.0, *known), 1.1 * max(level, *known))
    axes.set_xticks(range(len(chart.rows)), chart.rows)
    axes.tick_params(axis="x", length=0)
    solves = chart.constants["solves"] / len(chart.series)
    axes.set_ylabel("growth [MB]")
    axes.set_xlabel(f"a bar for each {solves:g} solves, in their order")
    return figure


def spaced(groups: Sequence[str], gap: float = 1.6) -> Iterator[float]:
    """Yield the places of rows from above, with a gap where another group begins."""
    place, before = 0.0, groups[0]
    for index, group in enumerate(groups):
        place += (1.0 if index else 0.0) + (gap if group != before else 0.0)
        before = group
        yield place


def panels(
    spans: Sequence[tuple[float, float]], height: float, top: float, bottom: float = 46.0
) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels beside each other.

    Args:
        spans: Left and right end of each panel [pt].
        height: Height of the panels [pt].
        top: What is above them [pt].
        bottom: What is below them [pt].
    """
    whole = height + top + bottom
    figure = Figure(figsize=(WIDTH / 72.0, whole / 72.0))
    figure.patch.set_alpha(0.0)
    FigureCanvasSVG(figure)
    places = [
        (left / WIDTH, bottom / whole, (right - left) / WIDTH, height / whole)
        for left, right in spans
    ]
    return figure, [figure.add_axes(place) for place in places]


def name_rows(
    axes: Axes, places: Sequence[float], names: Sequence[str], lines: bool = True
) -> None:
    """Write names beside rows, the first above; lines lead from them to what is plotted."""
    axes.set_yticks([])
    for place, name in zip(places, names, strict=True):
        write(axes, name, (0.0, place), (-4.0, 0.0), "right")
    axes.set_ylim(max(places) + 0.7, min(places) - 0.7)
    axes.spines["left"].set_visible(False)
    if lines:
        axes.hlines(places, 0.0, 1.0, TEXT, lw=0.4, alpha=0.5, transform=axes.get_yaxis_transform())


def log_axis(axes: Axes, ticks: Sequence[float], limits: tuple[float, float], label: str) -> None:
    """Make the horizontal axis logarithmic."""
    axes.set_xscale("log")
    axes.set_xlim(*limits)
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for index, line in enumerate(label.split("\n")):
        below = -(26.0 + LINE * index)
        axes.annotate(
            line,
            (0.5, 0.0),
            (0.0, below),
            "axes fraction",
            "offset points",
            ha="center",
            va="center",
        )


def line_at_one(axes: Axes, key: str, places: Sequence[float], groups: Sequence[str] = ()) -> None:
    """Draw where both sides take the same, but not through the titles of groups."""
    parts = [list(places)]
    if groups:
        named = list(zip(groups, places, strict=True))
        parts = [[p for name, p in named if name == group] for group in dict.fromkeys(groups)]
    above, below = [part[0] - 0.7 for part in parts], [part[-1] + 0.7 for part in parts]
    axes.vlines([1.0] * len(parts), above, below, TEXT, lw=1.2, gid=key)


def dots(
    axes: Axes,
    key: str,
    values: Numbers,
    places: Sequence[float],
    color: str,
    label: str,
    marker: str = "o",
    size: float = 6.5,
) -> None:
    """Draw a mark for every number there is; the kind of mark tells what the colour tells, too."""
    x, y = known_points(values, places)
    face = color if marker == "o" else "none"
    axes.plot(
        x, y, ls="", marker=marker, ms=size, mec=color, mfc=face, label=label, gid=key
    )  # fmt: skip


def marks(axes: Axes, key: str, values: Numbers, places: Sequence[float], label: str) -> None:
    """Draw a short upright line for every limit or target."""
    x, y = known_points(values, places)
    axes.plot(x, y, ls="", marker="|", ms=16.0, mew=2.0, color=TEXT, label=label, gid=key)


def known_points(values: Numbers, places: Sequence[float]) -> tuple[list[float], list[float]]:
    """Return the numbers that there are, and the places of their rows."""
    known = [
        (value, place) for value, place in zip(values, places, strict=True) if value is not None
    ]
    return [value for value, _ in known], [place for _, place in known]


def legend(figure: Figure, axes: Axes, columns: int = 1, above: float = 6.0) -> None:
    """Write what the marks mean above a panel [pt], from the figure's left edge on."""
    width, height = 72.0 * figure.get_size_inches()
    place = (4.0 / width, axes.get_position().y1 + above / height)
    axes.legend(
        loc="lower left", bbox_to_anchor=place, bbox_transform=figure.transFigure, ncols=columns
    )


def beside(
    axes: Axes, places: Sequence[float], notes: Sequence[str], title: str, width: float
) -> None:
    """Write a column of so many points on the right of a panel, below its title."""
    for place, note in zip(places, notes, strict=True):
        write(axes, note, (1.0, place), (width, 0.0), "right")
    top = 4.0 + LINE / 2 * len(title.split("\n"))
    write(axes, title, (1.0, axes.get_ylim()[1]), (width, top), "right")


def write(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    offset: tuple[float, float],
    side: Literal["left", "right"],
    color: str = TEXT,
) -> None:
    """Write beside a row, each line for itself: else only in the font that was meant they align.

    Args:
        axes: A panel.
        text: One line or more.
        at: A fraction of the panel's width, and a row.
        offset: How far from there the middle of the text is, to the right and up [pt].
        side: Side of the text that is there.
        color: Color of the text.
    """
    lines = text.split("\n")
    for index, line in enumerate(lines):
        up = offset[1] + LINE * ((len(lines) - 1) / 2 - index)
        axes.annotate(
            line,
            at,
            (offset[0], up),
            xycoords=axes.get_yaxis_transform(),
            textcoords="offset points",
            ha=side,
            va="center",
            color=color,
        )


CHARTS: dict[str, tuple[Callable[[str], Chart], Callable[[Chart], Figure]]] = {
    "waiting": (waiting, draw_waiting),
    "equations": (equations, draw_equations),
    "matrix": (matrix, draw_matrix),
    "ompl": (ompl, draw_ompl),
    "dynobench": (dynobench, draw_dynobench),
    "memory": (memory, draw_memory),
}


def drawn(page: str) -> dict[str, str]:
    """Return the files, as text by name."""
    files = {}
    for name, (read, draw) in CHARTS.items():
        chart, out = read(page), io.StringIO()
        # Neither a date nor a version: both change without anything to be seen.
        about = {"Description": chart.description, "Date": None, "Creator": None}
        with mpl.rc_context(STYLE):
            draw(chart).savefig(out, format="svg", metadata=about)
        lines = (line.rstrip() for line in out.getvalue().splitlines())
        files[f"{name}.svg"] = "\n".join(lines) + "\n"
    return files


def main() -> int:
    """Write the files, or check them."""
    parser = argparse.ArgumentParser(description="Write docs/images/benchmarks/*.svg.")
    parser.add_argument("--check", action="store_true", help="write nothing, show what differs")
    options = parser.parse_args()
    files = drawn(PAGE.read_text(encoding="utf-8"))
    if options.check:
        return 1 if differ(files) else 0
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    return 0


def differ(files: dict[str, str]) -> bool:
    """Show how the files differ from what they should be, and say whether they do."""
    there = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.svg")}
    for name in sorted(files.keys() | there.keys()):
        before, after = (kind.get(name, "").splitlines(keepends=True) for kind in (there, files))
        sys.stdout.writelines(difflib.unified_diff(before, after, name, "as it should be"))
    return files != there


if __name__ == "__main__":
    sys.exit(main())
