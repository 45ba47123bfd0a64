"""Write the notebooks of the course from its chapters in docs/course, without the solutions.

    python tools/write_course.py [--check]

With --check nothing is written: it returns 1 if a notebook is not as its chapter says.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

import nbformat
from myst_nb.core.read import read_myst_markdown_notebook

ROOT = Path(__file__).resolve().parents[1]
CHAPTERS, NOTEBOOKS = ROOT / "docs" / "course", ROOT / "src" / "kinolab" / "cli" / "course"
BOOK_ONLY = {"exercise", "hide-input", "skip-execution"}  # tags that a notebook does without


def notebook_of(chapter: Path) -> str:
    """Return a chapter as the content of a notebook."""
    notebook: Any = read_myst_markdown_notebook(chapter.read_text(encoding="utf-8"))
    cells = []
    for cell in notebook.cells:
        tags = set(cell.metadata.get("tags", ()))
        if "solution" in tags:
            continue
        cell.metadata = {"tags": sorted(tags - BOOK_ONLY)} if tags - BOOK_ONLY else {}
        cell.id = f"cell-{len(cells)}"
        if cell.cell_type == "markdown":
            cell.source = _linked(cell.source)
        cells.append(cell)
    notebook.cells = cells
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook.metadata = {"kernelspec": kernel}
    nbformat.validate(notebook)
    return str(nbformat.writes(notebook)) + "\n"


def _linked(text: str) -> str:
    """Let links to chapters lead to notebooks, and leave those to other pages out."""
    text = re.sub(r"\]\((\d\d_\w+)\.md\)", r"](\1.ipynb)", text)
    return re.sub(r"\[([^\]]+)\]\((?:\.\./)?[a-z_]+\.md(?:#[\w-]*)?\)", r"\1", text)


def main() -> int:
    """Write the notebooks, or check them."""
    parser = argparse.ArgumentParser(description="Write the course's notebooks.")
    parser.add_argument("--check", action="store_true", help="write nothing, say what differs")
    options = parser.parse_args()
    wanted = {
        f"{path.stem}.ipynb": notebook_of(path) for path in sorted(CHAPTERS.glob("[0-9]*.md"))
    }
    there = {path.name: path.read_text(encoding="utf-8") for path in NOTEBOOKS.glob("*.ipynb")}
    if options.check:
        differing = [name for name in sorted(wanted | there) if wanted.get(name) != there.get(name)]
        print("\n".join(f"{name} is not as its chapter says" for name in differing))
        return 1 if differing else 0
    for name in there:
        (NOTEBOOKS / name).unlink()
    for name, text in wanted.items():
        (NOTEBOOKS / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
