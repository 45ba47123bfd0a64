"""Write machines.md, scenarios.md, files.md and benchmarking.md in docs/ from code and manual.

    python tools/write_manual.py [--check]

With --check nothing is written: it shows how the pages differ and returns 1 if one does. Prose and
examples stand in the Markdown files of ``kinolab.cli.manual``, all else in what they explain.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from pathlib import Path

from kinolab.cli.manual import PAGES

DOCS = Path(__file__).resolve().parents[1] / "docs"


def main() -> int:
    """Write the pages, or check them."""
    parser = argparse.ArgumentParser(description="Write the manual in docs/.")
    parser.add_argument("--check", action="store_true", help="write nothing, show what differs")
    options = parser.parse_args()
    same = True
    for page in PAGES.values():
        path, text = DOCS / page.file, page.text()
        if not options.check:
            path.write_text(text, encoding="utf-8")
            continue
        written = path.read_text(encoding="utf-8") if path.exists() else ""
        before, after = written.splitlines(keepends=True), text.splitlines(keepends=True)
        sys.stdout.writelines(difflib.unified_diff(before, after, path.name, "as it should be"))
        same &= text == written
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
