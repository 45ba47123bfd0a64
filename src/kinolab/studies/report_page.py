"""The report of a study: one page that stands alone, and its tables as Markdown."""

from __future__ import annotations

import html
import io
import json
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kinolab.errors import printable
from kinolab.files import utf_8, write_whole
from kinolab.scenario.toml_text import shortened, value_text
from kinolab.studies.columns import Row
from kinolab.studies.comparison import (
    MOST_COMPARED,
    SIGNIFICANT,
    Comparison,
    Group,
    Interval,
    comparisons,
    grouped,
)
from kinolab.studies.expansion import run_count
from kinolab.studies.study_file import NamedPlanner, Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAGE, TEXT = "report.html", "report.md"
INK = "#7a7a7a"  # readable on white and on black
METADATA = ("Creator", "Date", "Format", "Type")  # that Matplotlib writes unless they are None
LEGEND = (
    "*solved*: runs with a verified plan, and the 95 % interval of their share (Wilson). "
    "*search*: median processor time of a search with its 95 % interval (order statistics); a run "
    "that is not solved counts as one that never ends. *motion*: median duration of the motions of "
    "solved runs. *memory*: median of the largest resident memory, libraries included. *other "
    "ends*: how the others ended. Of fewer than 6 runs there is no interval of a median. Where a "
    f"scenario has more than {MOST_COMPARED} planners with settings, all settings of a planner "
    "are one row."
)
COMPARED = (
    "*ratio*: median search time of the first divided by that of the second, 95 % interval by "
    "bootstrap. *sooner*: probability that a run of the first is solved sooner than one of the "
    "second, ties half; *shorter*: the same for the durations of motions. p: Fisher's exact test "
    "(solved), Mann and Whitney's (time, duration), each corrected by Holm's method for all pairs "
    "of a scenario; "
    f"**bold** below {SIGNIFICANT:g}."
)
TOO_MANY = f"More than {MOST_COMPARED} planners are not compared in pairs."
Table = list[list[str]]


def write_report(folder: Path, study: Study, rows: Sequence[Row]) -> list[Path]:
    """Write report.html and report.md into a folder; return their paths.

    Raises:
        InputError: If Matplotlib is not installed.
    """
    groups = grouped(rows)
    pairs = comparisons(groups)
    page, text = folder / PAGE, folder / TEXT
    write_whole(page, utf_8(page_of(study, rows, groups, pairs)))
    write_whole(text, utf_8(markdown_of(study, rows, groups, pairs)))
    return [page, text]


def markdown_of(
    study: Study, rows: Sequence[Row], groups: Sequence[Group], pairs: Sequence[Comparison]
) -> str:
    """Return the report's tables as Markdown."""
    parts = [
        f"# {_plain(study.title)}",
        *map(_plain, sentences(study, rows)),
        _markdown(summary(groups)),
        LEGEND,
        *map(_plain, _messages(rows)),
    ]
    planners = Counter((group.scenario, group.computer) for group in groups)
    if pairs:
        parts += [_markdown(comparison_table(pairs)), COMPARED]
    elif max(planners.values(), default=0) > MOST_COMPARED:
        parts.append(TOO_MANY)
    return "\n\n".join(parts) + "\n"


def page_of(
    study: Study, rows: Sequence[Row], groups: Sequence[Group], pairs: Sequence[Comparison]
) -> str:
    """Return the report as a page that needs nothing else."""
    several = len({group.computer for group in groups}) > 1
    body = [f"<h1>{_escaped(study.title)}</h1>"]
    for k, sentence in enumerate(sentences(study, rows)):
        kind = "warning" if several and k == 0 else "note"
        body.append(f'<p class="{kind}">{_inline(sentence)}</p>')
    body += [_html(summary(groups)), f'<p class="note">{_inline(LEGEND)}</p>']
    body += [f'<p class="warning">{_escaped(text)}</p>' for text in _messages(rows)]
    for place in dict.fromkeys((group.scenario, group.computer) for group in groups):
        own = [group for group in groups if (group.scenario, group.computer) == place]
        title = place[0] + (f", on {place[1]}" if several else "")
        body += [f"<h2>{_escaped(title)}</h2>", *_figures(own, title)]
        compared = [pair for pair in pairs if pair.first in own]
        if compared:
            body += [_html(comparison_table(compared)), f'<p class="note">{_inline(COMPARED)}</p>']
        elif len(own) > MOST_COMPARED:
            body.append(f'<p class="note">{TOO_MANY}</p>')
    page = files("kinolab.studies").joinpath(PAGE).read_text("utf-8")
    return Template(page).substitute(title=_escaped(study.title), body="\n".join(body))


def sentences(study: Study, rows: Sequence[Row]) -> Iterator[str]:
    """Yield what must be known about the figures; what may mislead comes first."""
    computers = {row["computer"]: row for row in rows if row["computer"]}
    if len(computers) > 1:
        yield (
            f"The runs were made on {len(computers)} kinds of computers (or with as many sets of "
            "versions). Times are compared within each kind only."
        )
    if len(rows) < (of := run_count(study)):
        yield f"These are {len(rows)} of the {of} runs of the study."
    for name, row in computers.items():
        versions = json.loads(row["versions"])
        loads = [r["load"] for r in rows if r["computer"] == name and r["load"] is not None]
        count = sum(r["computer"] == name for r in rows)
        which = f"{name}: " if len(computers) > 1 else ""
        yield (
            f"{which}{row['processor']}, {row['cores']} cores, {row['system']}, Python "
            f"{versions.get('python')}, kinolab {versions.get('kinolab')}; {count} runs at load "
            f"averages of {min(loads, default=0.0):.1f} to {max(loads, default=0.0):.1f}."
        )
        if max(loads, default=0.0) > 1.5 * row["cores"]:
            yield "The load was higher than there are processors: times are longer than when quiet."
    limits = {
        "search": (study.limits.search, "s of search"),
        "iterations": (study.limits.iterations, "iterations"),
        "cpu": (study.limits.cpu, "s of processor time"),
        "memory": (study.limits.memory, "MB"),
    }
    given = [f"{value:g} {unit}" for value, unit in limits.values() if value is not None]
    yield f"Limits of a run: {', '.join(given) if given else 'those of its scenario'}."
    yield from _told_by_cases(study)
    lacking = sum(bool(row["checked"] is False) for row in rows)
    if lacking:
        yield f"{lacking} solved runs did not pass the check of their files."


def _told_by_cases(study: Study) -> Iterator[str]:
    """Yield what the study sets, as far as the names of planners do not say it."""
    improved = {bool(case.improve) for case in study.cases}
    if improved == {True}:
        yield "Motions were made exact and shorter; *motion* is after that."
    elif improved == {True, False}:
        yield "In some cases motions were made exact and shorter, in others not."
    if any(case.check for case in study.cases):
        yield "Solved runs were checked once more from their files."
    for case in study.cases:
        told = {**(case.settings or {})}
        for planner in case.planners or []:
            if isinstance(planner, NamedPlanner) and planner.settings:
                label = planner.label or planner.name
                told |= {f"{label}: {key}": value for key, value in planner.settings.items()}
        if told:
            named = "; ".join(f"{key} = {value_text(value)}" for key, value in told.items())
            yield f"Set for {', '.join(case.scenarios or [])}: {named}."


def _messages(rows: Sequence[Row]) -> Iterator[str]:
    """Yield what runs said that failed by a mistake or a crash, each once."""
    said = Counter(
        (row["status"], str(row["message"]).strip().splitlines()[-1])
        for row in rows
        if row["status"] in ("error", "crashed", "killed", "out_of_memory") and row["message"]
    )
    for (status, text), count in said.most_common(5):  # that are quoted
        yield f"{status} ({count}): {text}"


def summary(groups: Sequence[Group]) -> Table:
    """Return the table of all planners, heading first."""
    several = len({group.computer for group in groups}) > 1
    heading = ["scenario", "planner", *(["computer"] if several else [])]
    table = [[*heading, "solved", "search [s]", "motion [s]", "memory [MB]", "other ends"]]
    for group in groups:
        share = group.share
        memory = [row["memory"] for row in group.rows if row["memory"] is not None]
        ends = Counter(row["status"] for row in group.rows if not row["solved"])
        table.append(
            [
                group.scenario,
                group.planner,
                *([group.computer] if several else []),
                f"{group.solved}/{len(group.rows)} ({share.low:.0%} to {share.high:.0%})",
                spoken(group.time),
                spoken(group.duration),
                f"{np.median(memory):.0f}" if memory else "–",
                ", ".join(f"{name} ({count})" for name, count in sorted(ends.items())) or "–",
            ]
        )
    return table


def comparison_table(pairs: Sequence[Comparison]) -> Table:
    """Return the table of pairs, heading first."""
    heading = ["scenario", "first", "second", "ratio", "sooner", "shorter"]
    table = [[*heading, "p solved", "p time", "p duration"]]
    for pair in pairs:
        table.append(
            [
                *(pair.first.scenario, pair.first.planner, pair.second.planner),
                spoken(pair.ratio),
                _share(pair.sooner),
                _share(pair.shorter),
                *(_p(value) for value in (pair.p_solved, pair.p_time, pair.p_duration)),
            ]
        )
    return table


def spoken(interval: Interval) -> str:
    """Return a figure with its interval; ∞ where too few runs are solved."""
    if math.isnan(interval.value):
        return "–"
    if math.isnan(interval.low) or math.isinf(interval.low):
        return _figure(interval.value)
    low, high = _figure(interval.low), _figure(interval.high)
    return f"{_figure(interval.value)} ({low} to {high})"


def _figure(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.3g}"


def _share(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.0%}"


def _p(value: float) -> str:
    if math.isnan(value):
        return "–"
    text = "<0.001" if value < 0.001 else f"{value:.3f}"
    return f"**{text}**" if value < SIGNIFICANT else text


def _markdown(table: Table) -> str:
    rows = [table[0], ["---"] * len(table[0]), *table[1:]]
    return "\n".join(
        f"| {' | '.join(_plain(cell).replace('|', '/') for cell in row)} |" for row in rows
    )


def _plain(text: str) -> str:
    """Return text as a line of Markdown without HTML or links; stars still emphasise."""
    line = printable(" ".join(text.split())).replace("<", "&lt;")
    return re.sub(r"\](?=[(:\[])", r"]\\", line)


def _label(text: str) -> str:
    """Return a text as Matplotlib draws it: dollars are no formulas, all labels are shown."""
    text = printable(shortened(text, 80))  # characters, for which a figure has room
    return (f" {text}" if text.startswith("_") else text).replace("$", r"\$")


def _html(table: Table) -> str:
    heading = "".join(f"<th>{_escaped(cell)}</th>" for cell in table[0])
    rows = "".join(
        f"<tr>{''.join(f'<td>{_inline(cell)}</td>' for cell in row)}</tr>\n" for row in table[1:]
    )
    return f"<table><thead><tr>{heading}</tr></thead><tbody>\n{rows}</tbody></table>"


def _escaped(text: str) -> str:
    """Return text as HTML, without characters that a page or an editor would obey."""
    return html.escape(printable(text))


def _inline(text: str) -> str:
    """Return text as HTML; what Markdown marks by stars is emphasised."""
    escaped = _escaped(text)
    for stars, tag in (("**", "strong"), ("*", "em")):
        parts = escaped.split(stars)
        if len(parts) % 2:
            escaped = "".join(
                part if k % 2 == 0 else f"<{tag}>{part}</{tag}>" for k, part in enumerate(parts)
            )
    return escaped


def _figures(groups: Sequence[Group], title: str) -> Iterator[str]:
    """Yield figures as HTML: solved over time, times and durations, and swept settings."""
    drawn = groups[:MOST_COMPARED]
    yield _figure_html(
        _over_time(drawn),
        f"{title}: share of runs solved over the processor time of the search, and box plots of "
        "search times and of durations of the motions (solved runs; boxes are quartiles, whiskers "
        "reach to 1.5 times their distance).",
    )
    if len(groups) > MOST_COMPARED:
        yield f'<p class="note">The first {MOST_COMPARED} of {len(groups)} planners are drawn.</p>'
    for key in _swept_numbers(groups):
        yield _figure_html(
            _against(groups, key), f"{title}: search time of each run against {key}."
        )


def _over_time(groups: Sequence[Group]) -> Figure:
    figure = _new_figure((11.0, 3.6 + 0.12 * len(groups)))
    curve, times, durations = figure.subplots(1, 3, width_ratios=[1.2, 1, 1])
    for k, group in enumerate(groups):
        found = np.sort(group.times[np.isfinite(group.times)])
        share = np.arange(1, len(found) + 1) / len(group.rows)
        if len(found):
            end = max(float(row["search"] or 0.0) for g in groups for row in g.rows)
            curve.step(
                [*found, max(end, found[-1])], [*share, share[-1]], where="post", color=f"C{k}"
            )
        curve.plot([], [], color=f"C{k}", label=_label(group.planner))
    curve.set(ylim=(0, 1.03), xlabel="search [s]", ylabel="share solved")
    curve.legend(fontsize=7, loc="lower right", labelcolor=INK, framealpha=0.0)
    _boxes(times, [g.times[np.isfinite(g.times)] for g in groups], groups, "search [s]")
    if any(np.isfinite(group.times).any() for group in groups):  # no logarithm of nothing
        _log(curve, "x")
        _log(times, "x")
    _boxes(durations, [g.durations for g in groups], groups, "motion [s]")
    durations.set_yticklabels([])
    return figure


def _log(axes: Axes, name: Literal["x", "y"]) -> None:
    """Make an axis logarithmic, with plain numbers at 1, 2 and 5 of each decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set(**{f"{name}scale": "log"})
    axis = axes.xaxis if name == "x" else axes.yaxis
    axis.set_major_locator(LogLocator(10.0, (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _boxes(axes: Axes, values: Sequence[Any], groups: Sequence[Group], label: str) -> None:
    colour: dict[str, Any] = {"color": INK}
    axes.boxplot(
        list(values), orientation="horizontal", tick_labels=[_label(g.planner) for g in groups],
        boxprops=colour, whiskerprops=colour, capprops=colour,
        medianprops={"color": "#d62728"}, flierprops={"markeredgecolor": INK, "markersize": 3},
    )  # fmt: skip
    axes.invert_yaxis()
    axes.set_xlabel(label)
    axes.tick_params(axis="y", labelsize=7)


def _swept_numbers(groups: Sequence[Group]) -> list[str]:
    """Return the keys whose values are numbers, of which there are several."""
    found: dict[str, set[float]] = defaultdict(set)
    for group in groups:
        for row in group.rows:
            for key, value in _swept(row).items():
                found[key].add(value)
    return [key for key, values in found.items() if len(values) > 2]


def _swept(row: Row) -> dict[str, float]:
    """Return the numbers that were swept, by key."""
    swept = json.loads(row["settings"] or "{}").items()
    return {key: v for key, v in swept if isinstance(v, int | float) and not isinstance(v, bool)}


def _against(groups: Sequence[Group], key: str) -> Figure:
    figure = _new_figure((7.0, 3.4))
    axes = figure.subplots()
    rows = [
        (row["planner"], bool(row["solved"]), _swept(row)[key], row["search"])
        for group in groups
        for row in group.rows
        if row["search"] is not None and key in _swept(row)
    ]
    for k, planner in enumerate(dict.fromkeys(row[0] for row in rows)):
        for solved, marker in ((True, "o"), (False, "x")):
            own = [row[2:] for row in rows if row[:2] == (planner, solved)]
            x, y = zip(*own, strict=True) if own else ((), ())
            axes.plot(x, y, marker, color=f"C{k}", markersize=4, alpha=0.6)
        axes.plot([], [], "o", color=f"C{k}", label=_label(planner))
    if not all(row[1] for row in rows):
        axes.plot([], [], "x", color=INK, label="not solved")
    if rows:
        _log(axes, "y")
        swept = [row[2] for row in rows]
        # 20.0: a positive range whose ends differ by more has a logarithmic axis
        if min(swept) > 0.0 and max(swept) > 20.0 * min(swept):
            _log(axes, "x")
    axes.set(xlabel=_label(key), ylabel="search [s]")
    if rows:
        axes.legend(fontsize=7, labelcolor=INK, framealpha=0.0)
    return figure


def _new_figure(size: tuple[float, float]) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained")


def _figure_html(figure: Figure, caption: str) -> str:
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    for axes in figure.axes:
        axes.patch.set_alpha(0.0)
        axes.tick_params(colors=INK, which="both")
        axes.xaxis.label.set_color(INK)
        axes.yaxis.label.set_color(INK)
        for spine in axes.spines.values():
            spine.set_color(INK)
    figure.patch.set_alpha(0.0)
    out = io.StringIO()
    FigureCanvasSVG(figure)
    with mpl.rc_context({"svg.fonttype": "none"}):
        figure.savefig(out, format="svg", metadata=dict.fromkeys(METADATA))
    svg = out.getvalue()
    svg = svg[svg.index("<svg") :].replace("<svg ", '<svg role="img" ', 1)
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg, count=2)  # HTML knows its names
    said = _escaped(caption)
    return f"<figure>{svg}<figcaption>{said}</figcaption></figure>"
