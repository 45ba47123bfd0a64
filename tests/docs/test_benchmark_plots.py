"""The plots in docs/benchmarks.md show the numbers of its tables.

What a table has is read here in a way of its own: by the position of its columns. Where a mark
stands is read from the drawing itself. Another version of Matplotlib may write other text for the
same picture, so the files are not compared as text.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from runpy import run_path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.support import ROOT

SCRIPT = run_path(str(ROOT / "tools" / "write_benchmark_plots.py"))
DOCS = ROOT / "docs"
PAGE = (DOCS / "benchmarks.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"!\[([^]]*)\]\(images/benchmarks/(\w+)\.svg\)\n\n(\*[^|]*?\.\*)\n\n", PAGE)
NAMES = [name for _, name, _ in SHOWN]

# Names of series, with what is drawn on the same axis, and the lines at 1.
PANELS = [
    ("waiting", ("end", "motion"), "one"),
    ("equations", ("f", "Pinocchio", "limit"), None),
    ("ompl", ("ratio", "lower", "upper", "target"), "one"),
    ("dynobench", ("cost", "cost-iDb-A"), "one-cost"),
    ("dynobench", ("time",), "one-time"),
]

# Small tables with what is around them, and what must be read from them.
SMALL = """\
# Measured

## What somebody waits for

With little else running (load 1.3 at the end):

| command | verdict | summary | end | motion |
| --- | --- | --- | --- | --- |
| `python -c import kinolab` | – | – | 0.03 (0.6) | – |
| `plan --help` | – | – | 0.06 (1.0) | – |
| `plan check, crane_factory as found` | – | – | 0.57 (3.8) | 102.75 (1.0) |

Words between them:

| command | verdict | summary | end | motion |
| --- | --- | --- | --- | --- |
| `plan two_cranes` | 2.53 (1.6) | 2.59 (2.3) | 3.28 (2.0) | 5.84 (1.1) |

## From definition to compiled equations of motion

| machine | cold [s] | limit | warm [ms] | limit | f [ns] | limit | batch | Pinocchio [ns] |
|---|---|---|---|---|---|---|---|---|
| free body, 6 links | 1.41 | 4 | 6.3 | 50 | 1091 | 4000 | +2 % | 3235 |

On a busy computer (load 4.9), where it takes 1714 ns:

| machine | cold [s] | limit | warm [ms] | limit | f [ns] | limit | batch | Pinocchio [ns] |
|---|---|---|---|---|---|---|---|---|
| marionette | 14.68 | 5 | 134.1 | 50 | 6,009 | 12500 | -13 % | 10991 |

## The matrix: planners against scenarios

| planner | rolling_disk_maze | vehicle_parking |
| --- | --- | --- |
| rrt | 5/5, 2.8 s, 26 s | 5/5, 25.4 s, 60 s |

| planner | crane_factory | vehicle_parking |
| --- | --- | --- |
| prm | 5/5, 3.9 s, 88 s |  |

## Beside OMPL in C++

| problem | planner | clock: median |
| --- | --- | --- |
| disk | OMPL RRT | 0.1 |

| problem | compared | OMPL, median [s] | kinolab, median [s] | ratio | 95 % interval | target | \
OMPL solved | kinolab solved |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
| disk | RRT against rrt_fast, as OMPL's RRT | RRT 0.1 | rrt_fast 0.05 | 2.3 | 2.1 to 2.6 | 5 | \
198/200 | 200/200 |
| crane | best against best | RRT 0.09 | kpiece_fast 0.02 | 3.9 | 2.7 to 6.3 | 2 | \
169/200 | 200/200 |

## The problems of dynobench

| problem | authors | strict | time [s] | first [s] | final [s] | clearance [m] | offline [s] | \
iDb-A* | RRT*+TO | SST* | best [s] |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
| car1_v0/kink_0 | 3/3 | 3/3 | 0.40 | 53.20 | 30.00 | 0.0051 | 0.37 | \
1, 0.8, 23, 15 | 1, 1.9, 86.1, 21.2 | 0, – | 12 |
| acrobot_v0/swing | 3/3 | 3/3 | 2.00 | 2.61 | 2.00 | – | 0.36 | 0, – | 0, – | 0, – | 4 |

## Memory: a thousand solves in one process

AMD EPYC, 2 cores, Python 3.11.7, OMPL 2.0.1. The limit is 20 MB.

| planner | solves | growth, MB | by quarters, MB | MB per 1000 at most |
| --- | --- | --- | --- | --- |
| est | 1000 (999 solved) | +1.41 | +0.10 -0.49 +0.82 +0.00 | 0.00 |
"""
READ: dict[str, dict[str, list[float | None]]] = {
    "waiting": {"end": [0.6, 1.0, 3.8, 2.0], "motion": [None, None, 1.0, 1.1]},
    "equations": {
        "f": [1091.0, 6009.0],
        "Pinocchio": [3235.0, 10991.0],
        "limit": [4000.0, 12500.0],
    },
    "matrix": {
        "crane_factory": [None, 3.9],
        "rolling_disk_maze": [2.8, None],
        "vehicle_parking": [25.4, None],
    },
    "ompl": {
        "ratio": [2.3, 3.9],
        "lower": [2.1, 2.7],
        "upper": [2.6, 6.3],
        "target": [5.0, 2.0],
    },
    "dynobench": {"cost": [2.5, 0.5], "cost-iDb-A": [1.25, None], "time": [0.5, None]},
    "memory": {"quarter-1": [0.1], "quarter-2": [-0.49], "quarter-3": [0.82], "quarter-4": [0.0]},
}


def rows_below(heading: str, first: str) -> list[list[str]]:
    """Return the cells of a section's rows, from tables whose line of headings begins like that."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    found, inside = [], False
    for line in section.splitlines():
        if not line.startswith("|"):
            inside = False
        elif line.startswith(first):
            inside = True
        elif inside and not line.startswith(("|---", "| ---")):
            found.append([cell.strip() for cell in line[1:-1].split("|")])
    return found


def within(cell: str) -> float | None:
    """Return the number in brackets."""
    return None if cell == "–" else float(cell[cell.index("(") + 1 : -1])


def of_waiting() -> dict[str, list[float | None]]:
    rows = rows_below("What somebody waits for", "| command |")
    return {"end": [within(row[3]) for row in rows], "motion": [within(row[4]) for row in rows]}


def of_equations() -> dict[str, list[float | None]]:
    rows = rows_below("From definition to compiled equations of motion", "| machine |")
    places = {"f": 5, "limit": 6, "Pinocchio": 8}
    return {key: [float(row[place]) for row in rows] for key, place in places.items()}


def of_ompl() -> dict[str, list[float | None]]:
    rows = rows_below("Beside OMPL in C++", "| problem | compared |")
    return {
        "ratio": [float(row[4]) for row in rows],
        "lower": [float(row[5].split()[0]) for row in rows],
        "upper": [float(row[5].split()[2]) for row in rows],
        "target": [float(row[6]) for row in rows],
    }


def of_dynobench() -> dict[str, list[float | None]]:
    rows = rows_below("The problems of dynobench", "| problem |")
    theirs = [[float(part) for part in row[8].split(", ")] for row in rows]
    best = [float(row[11]) for row in rows]
    return {
        "cost": [float(row[5]) / of for row, of in zip(rows, best, strict=True)],
        "cost-iDb-A": [row[3] / of for row, of in zip(theirs, best, strict=True)],
        "time": [float(row[3]) / other[1] for row, other in zip(rows, theirs, strict=True)],
    }


def of_matrix() -> dict[str, list[float | None]]:
    """Return the columns of two tables, one below the other."""
    section = PAGE.split("\n## The matrix: planners against scenarios\n")[1].split("\n## ")[0]
    heads = [line[2:-2].split(" | ")[1:] for line in section.splitlines() if "| planner |" in line]
    cells = rows_below("The matrix: planners against scenarios", "| planner |")
    first = next(index for index, row in enumerate(cells) if row[0] == "prm")
    series: dict[str, list[float | None]] = {
        name: [None] * len(cells) for head in heads for name in head
    }
    for index, row in enumerate(cells):
        for name, cell in zip(heads[index >= first], row[1:], strict=True):
            series[name][index] = float(cell.split()[1]) if cell else None
    return series


def of_memory() -> dict[str, list[float | None]]:
    rows = rows_below("Memory: a thousand solves in one process", "| planner |")
    return {f"quarter-{i + 1}": [float(row[3].split()[i]) for row in rows] for i in range(4)}


EXPECTED = {
    "waiting": of_waiting(),
    "equations": of_equations(),
    "matrix": of_matrix(),
    "ompl": of_ompl(),
    "dynobench": of_dynobench(),
    "memory": of_memory(),
}


@cache
def drawing(name: str) -> ElementTree.Element:
    """Return a file as it stands in docs."""
    return ElementTree.parse(DOCS / "images" / "benchmarks" / f"{name}.svg").getroot()


def numbers(name: str) -> dict[str, Any]:
    """Return what a file says that it plots."""
    found = drawing(name).find(".//{http://purl.org/dc/elements/1.1/}description")
    assert found is not None
    return dict(json.loads(found.text or ""))


def group(name: str, key: str) -> ElementTree.Element:
    """Return what a series is drawn with."""
    (found,) = (part for part in drawing(name).iter() if part.get("id") == key)
    return found


def marks(name: str, key: str) -> list[tuple[float, float]]:
    """Return where the marks of a series stand [pt]."""
    found = [part for part in group(name, key).iter() if part.tag.endswith("}use")]
    return [(float(part.get("x", "nan")), float(part.get("y", "nan"))) for part in found]


def corners(name: str, key: str) -> list[tuple[float, float]]:
    """Return the corners of what is drawn as a path [pt]."""
    paths = [part.get("d", "") for part in group(name, key).iter() if part.tag.endswith("}path")]
    pairs = re.findall(r"[ML] (\S+) (\S+)", "\n".join(paths))
    return [(float(x), float(y)) for x, y in pairs]


def known(values: Sequence[float | None]) -> list[float]:
    """Return the numbers that there are."""
    return [value for value in values if value is not None]


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours, by section 1.4.3 of WCAG 2.1."""
    levels = []
    for color in (one, other):
        parts = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
        linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        levels.append(0.05 + float(linear @ [0.2126, 0.7152, 0.0722]))
    return max(levels) / min(levels)


def test_every_plot_is_shown_once_with_words_and_no_other_lies_there() -> None:
    files = {path.stem for path in (DOCS / "images" / "benchmarks").iterdir()}
    assert sorted(NAMES) == sorted(files) == sorted(SCRIPT["CHARTS"])
    assert PAGE.count("images/benchmarks/") == len(NAMES)
    assert all(len(alternative) > 40 for alternative, _, _ in SHOWN)


@pytest.mark.parametrize("name", NAMES)
def test_a_plot_says_the_numbers_of_the_table(name: str) -> None:
    """If this fails: ``python tools/write_benchmark_plots.py``."""
    assert numbers(name)["series"].keys() == EXPECTED[name].keys()
    for key, values in EXPECTED[name].items():
        told = numbers(name)["series"][key]
        assert [value is None for value in told] == [value is None for value in values], key
        assert known(told) == pytest.approx(known(values), rel=1e-5), key


@pytest.mark.parametrize(("name", "keys", "one"), PANELS, ids=str)
def test_marks_stand_where_their_numbers_are_on_a_logarithmic_axis(
    name: str, keys: tuple[str, ...], one: str | None
) -> None:
    values = [value for key in keys for value in known(EXPECTED[name][key])]
    places = [x for key in keys for x, _ in marks(name, key)]
    if one:
        places.append(corners(name, one)[0][0])
        values.append(1.0)
    line = np.polyfit(np.log10(values), places, 1)
    assert line[0] > 20.0  # points of the page for a factor of ten
    np.testing.assert_allclose(np.polyval(line, np.log10(values)), places, atol=0.03)


@pytest.mark.parametrize(("name", "keys", "_one"), PANELS, ids=str)
def test_marks_stand_in_the_order_of_the_rows(
    name: str, keys: tuple[str, ...], _one: str | None
) -> None:
    heights: dict[int, float] = {}
    for key in keys:
        rows = [row for row, value in enumerate(EXPECTED[name][key]) if value is not None]
        for row, (_, y) in zip(rows, marks(name, key), strict=True):
            assert heights.setdefault(row, y) == pytest.approx(y, abs=0.01)
    ordered = [heights[row] for row in sorted(heights)]
    assert len(ordered) > 1
    assert ordered == sorted(ordered)


def test_the_plot_of_the_benchmark_counts_as_the_benchmark_does() -> None:
    """Its script prints the same two counts below its table."""
    series = numbers("dynobench")["series"]
    sooner = re.search(r"at or below iDb-A\*'s .*: (\d+) of (\d+)\.", PAGE)
    cheaper = re.search(r"Median cost within 5 % of the best published: (\d+) of (\d+)\.", PAGE)
    assert sooner
    assert cheaper
    assert [sum(value <= 1.0 for value in series["time"]), len(series["time"])] == [
        int(part) for part in sooner.groups()
    ]
    assert [sum(value <= 1.05 for value in series["cost"]), len(series["cost"])] == [
        int(part) for part in cheaper.groups()
    ]


def test_fields_of_the_matrix_have_the_numbers_as_text() -> None:
    written = [part.text for part in drawing("matrix").iter() if part.tag.endswith("}text")]
    fields = [text for text in written if re.fullmatch(r"\d+\.\d", text or "")]
    wanted = [f"{value:.1f}" for values in EXPECTED["matrix"].values() for value in known(values)]
    assert sorted(map(str, fields)) == sorted(wanted)


def test_bars_of_memory_begin_at_zero_and_are_as_high_as_their_numbers() -> None:
    level = corners("memory", "level")[0][1]
    planners = numbers("memory")["rows"]
    scale = None
    for key, values in EXPECTED["memory"].items():
        for planner, value in zip(planners, known(values), strict=True):
            heights = [y for _, y in corners("memory", f"{planner}-{key}")]
            ground, top = max(heights), min(heights)
            scale = scale or (ground - level) / (20.0 / 4)  # the page: "The limit is 20 MB."
            assert ground - top == pytest.approx(scale * value, abs=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_a_plot_is_small_and_fits_a_page(name: str) -> None:
    assert (DOCS / "images" / "benchmarks" / f"{name}.svg").stat().st_size < 60_000
    width = float(drawing(name).get("width", "").removesuffix("pt"))
    assert width * 96.0 / 72.0 <= 700.0  # pixels of a browser


@pytest.mark.parametrize("name", [name for name in NAMES if name != "matrix"])
@pytest.mark.parametrize("background", ["#ffffff", "#131416"])
def test_every_color_is_seen_on_a_light_and_on_a_dark_page(name: str, background: str) -> None:
    """3 is what WCAG asks for graphics and for large text; the matrix has fields of its own."""
    text = ElementTree.tostring(drawing(name), encoding="unicode")
    colors = set(re.findall(r"#[0-9a-f]{6}", text))
    assert len(colors) > 1
    assert all(contrast(color, background) > 3.0 for color in colors)


@pytest.mark.parametrize("name", READ)
def test_tables_are_read(name: str) -> None:
    read, _ = SCRIPT["CHARTS"][name]
    assert read(SMALL).series == READ[name]


def test_what_else_is_read() -> None:
    charts = {name: read(SMALL) for name, (read, _) in SCRIPT["CHARTS"].items()}
    assert charts["waiting"].rows == [
        *("import kinolab", "plan --help", "check, crane_factory", "two_cranes")
    ]
    assert charts["waiting"].notes == ["0.03 s", "0.06 s", "0.57 s", "3.28 s"]
    assert charts["waiting"].groups == [
        *["With little else running (load 1.3 at the end)"] * 3,
        "Words between them",
    ]
    assert charts["equations"].rows == ["free body,\n6 links", "marionette\n(load 4.9)"]
    assert charts["ompl"].rows == [
        "disk: RRT against rrt_fast\nas OMPL's RRT",
        "crane: best against best\nRRT against kpiece_fast",
    ]
    assert charts["ompl"].notes == ["198 : 200", "169 : 200"]
    assert charts["dynobench"].groups == ["car1_v0", "acrobot_v0"]
    assert charts["matrix"].constants == {"seeds": 5.0}
    assert charts["memory"].constants == {"limit": 20.0, "solves": 1000.0}


def test_a_table_that_is_gone_is_named() -> None:
    page = SMALL.replace("| by quarters, MB |", "| by thirds, MB |")
    with pytest.raises(LookupError, match="by quarters, MB below “Memory: a thousand solves"):
        SCRIPT["memory"](page)


def test_a_median_over_runs_that_failed_is_refused() -> None:
    page = SMALL.replace("5/5, 3.9 s", "4/5, 3.9 s")
    with pytest.raises(ValueError, match=r"4/5, 3\.9 s, 88 s: not every run was solved"):
        SCRIPT["matrix"](page)


def test_a_bound_is_refused() -> None:
    page = SMALL.replace("| 3/3 | 3/3 | 2.00 |", "| 1/3 | 1/3 | ≥ 20.00 |")
    with pytest.raises(ValueError, match=r"“≥ 20\.00” is only a bound"):
        SCRIPT["dynobench"](page)


def test_a_check_finds_what_is_out_of_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page, folder = tmp_path / "benchmarks.md", tmp_path / "plots"
    page.write_text(SMALL, encoding="utf-8")
    monkeypatch.setitem(SCRIPT["main"].__globals__, "PAGE", page)
    monkeypatch.setitem(SCRIPT["main"].__globals__, "FOLDER", folder)

    def run(*arguments: str) -> int:
        monkeypatch.setattr(sys, "argv", ["write_benchmark_plots.py", *arguments])
        return int(SCRIPT["main"]())

    assert run("--check") == 1
    assert not folder.exists()
    assert run() == 0
    assert {path.stem for path in folder.iterdir()} == set(READ)
    capsys.readouterr()
    assert run("--check") == 0
    assert capsys.readouterr().out == ""
    (folder / "older.svg").write_text("<svg/>", encoding="utf-8")
    assert run("--check") == 1
    (folder / "older.svg").unlink()
    page.write_text(SMALL.replace("(3.8)", "(3.9)"), encoding="utf-8")
    assert run("--check") == 1
    shown = capsys.readouterr().out
    assert "--- waiting.svg" in shown
    assert "--- memory.svg" not in shown
