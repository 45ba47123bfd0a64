"""The report stands alone, hides nothing and compares nothing that cannot be compared."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from kinolab.studies.report_page import write_report
from tests.studies.tiny_study import TINY, Row, row, several, study_in

NAN = float("nan")
SCRIPT = "<script>alert(1)</script>"


class Page(HTMLParser):
    """The tags of a page with their attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


def report(folder: Path, rows: list[Row], title: str = "Which one?") -> tuple[str, str]:
    """Return the page and the text of rows."""
    quote = '"' if "\\" in title else "'"
    study = study_in(folder, TINY.replace('"Which one swings up?"', f"{quote}{title}{quote}"))
    page, text = write_report(folder, study, rows)
    return page.read_text(encoding="utf-8"), text.read_text(encoding="utf-8")


def rows_of_three() -> list[Row]:
    swept = '{"planner.goal_bias": %s}'
    return [
        *several("rrt", [0.1, 0.2, NAN, 0.4]),
        *several("sst", [1.1, 1.2, 1.3, 1.4], first=4),
        *several("none", [NAN] * 4, first=8),
        *(row(12 + k, "rrt", settings=swept % (k / 10)) for k in range(1, 5)),
    ]


def test_the_page_needs_nothing_else(tmp_path: Path) -> None:
    text, _ = report(tmp_path, rows_of_three())
    assert "http://" not in text
    assert "https://" not in text
    page = Page(text)
    policy = next(about for tag, about in page.tags if "http-equiv" in about)
    assert policy["http-equiv"] == "Content-Security-Policy"
    assert (policy["content"] or "").startswith("default-src 'none'")
    assert {tag for tag, _ in page.tags}.isdisjoint(
        {"script", "link", "img", "image", "iframe", "object", "embed", "base", "form"}
    )
    for _, about in page.tags:
        assert "src" not in about
        for key, value in about.items():
            assert not key.startswith("on")
            if key in ("href", "xlink:href"):
                assert (value or "").startswith("#")
    assert all(address.startswith("#") for address in re.findall(r"url\(([^)]*)\)", text))
    assert "@import" not in text


def test_every_planner_is_shown_with_its_figures(tmp_path: Path) -> None:
    text, markdown = report(tmp_path, rows_of_three())
    page = Page(text)
    assert [tag for tag, _ in page.tags].count("svg") == 2  # over time, and what was swept
    for planner in ("rrt", "sst", "none", "rrt[goal_bias=0.1]", "rrt[goal_bias=0.4]"):
        assert f"<td>{planner}</td>" in text
        assert f"| table | {planner} |" in markdown
    assert "| table | rrt | 3/4 (30% to 95%) | 0.3 |" in markdown
    assert "| not_found (4) |" in markdown


def tables(markdown: str) -> list[list[list[str]]]:
    """Return the cells of all tables of a text in Markdown."""
    blocks = [block.splitlines() for block in markdown.split("\n\n") if block.startswith("|")]
    return [[line.strip("|").split("|") for line in lines] for lines in blocks]


def test_tables_have_equally_many_cells_in_every_row(tmp_path: Path) -> None:
    awkward = ["a|b", "two\nlines", "$x_{$", "_hidden", "*bold* **x**", SCRIPT, "50 % \\"]
    rows: list[Row] = []
    for name in awkward:
        rows += several(name, [0.1, 0.2], first=len(rows))
    text, markdown = report(tmp_path, rows)
    found = tables(markdown)
    assert [len(table) for table in found] == [2 + 7, 2 + 21]
    for table in found:
        assert len({len(line) for line in table}) == 1
    assert SCRIPT not in text
    assert Page(text).text.count("_hidden") >= 3  # table, pairs and legend
    assert "$x_{$" in Page(text).text


def test_a_title_is_text(tmp_path: Path) -> None:
    text, _ = report(tmp_path, [row(0)], SCRIPT)
    assert SCRIPT not in text
    assert SCRIPT in Page(text).text
    assert not any(tag == "script" for tag, _ in Page(text).tags)


ESCAPES = "A \\u001b[2J title\\u202e"  # as TOML has them


def test_control_characters_are_in_no_page(tmp_path: Path) -> None:
    """Of titles, names and messages: a terminal would obey them."""
    rows = [row(0, planner="\x1b[31mred"), row(1, status="error", message="\x1b]0;t\x07 \x9b1m")]
    text, markdown = report(tmp_path, rows, ESCAPES)
    for page in (text, markdown):
        assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]", page)


def test_kinds_of_computers_bring_a_warning_and_are_not_compared(tmp_path: Path) -> None:
    rows = [
        *several("rrt", [0.1, 0.2]),
        *several("sst", [0.3, 0.4], first=2, computer="bbbbbbbb", processor="Other CPU"),
    ]
    text, markdown = report(tmp_path, rows)
    assert '<p class="warning">The runs were made on 2 kinds of computers' in text
    assert "Some CPU" in text
    assert "Other CPU" in text
    (table,) = tables(markdown)  # and none of pairs
    assert [line[2].strip() for line in table] == ["computer", "---", "aaaaaaaa", "bbbbbbbb"]


def test_one_computer_brings_no_warning(tmp_path: Path) -> None:
    lost = row(1, status="killed", computer=None, versions=None, load=None, search=None)
    text, markdown = report(tmp_path, [row(0), lost])
    assert 'class="warning"' not in text
    assert "| table | rrt | 1/2 (" in markdown
    assert "| killed (1) |" in markdown


@pytest.mark.parametrize("status", ["not_found", "error"])
def test_a_study_that_solves_nothing_has_a_report(tmp_path: Path, status: str) -> None:
    search = 0.1 if status == "not_found" else None
    rows = [row(k, status=status, search=search, settings=f'{{"start.x": {k}}}') for k in range(3)]
    text, markdown = report(tmp_path, rows)
    assert markdown.count(f"| {status} (1) |") == 3
    assert text.count("<svg") == 2
