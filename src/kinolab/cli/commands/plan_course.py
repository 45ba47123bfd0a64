"""``plan course``: write the course's notebooks, or grade those that were handed in."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from importlib.resources import files
from pathlib import Path
from typing import Any

import click

from kinolab.cli.common import PATH
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say
from kinolab.errors import InputError, Mistake


@click.command("course")
@click.argument("folder", type=PATH, default=Path("course"))
@click.option("--grade", "graded", multiple=True, type=PATH, help="Work to grade.")
@click.option(
    "--against", type=PATH, help="What was asked for in projects: its scenario or machine."
)
@click.option("--due", is_flag=True, help="Say what would be right where an answer is not.")
@click.option("--jobs", default=1, show_default=True, help="How many are graded at once.")
def command(
    folder: Path, graded: Sequence[Path], against: Path | None, due: bool, jobs: int
) -> int:
    """Write the course's notebooks into FOLDER, or grade what was handed in.

    Notebooks that are there already are kept. --grade may be repeated; one piece of work gives a
    report, several give a table as CSV, while stderr says what is done and what each cell took.
    A project's machine is compared with that of --against: its motions, and the plan in its world.
    Graded code runs with your rights.
    """
    if graded:
        from kinolab.testing import grade, grade_class

        known: dict[str, Any] = {"against": against, "due": due}
        progress = Progress(quiet=False)
        with redirect_stdout(sys.stderr):
            if len(graded) == 1:
                report = str(grade(graded[0], told=progress, **known))
            else:
                report = grade_class(graded, jobs, told=progress, **known)
        progress.close()
        say(report)
        return 0
    for path, new in write_course(folder):
        say(f"{'written' if new else 'kept'} {path}")
    say(f"next: jupyter lab {folder}   (pip install 'kinolab[course]' brings it)")
    return 0


def write_course(folder: Path) -> list[tuple[Path, bool]]:
    """Write the notebooks that are not there; return the path of each, and whether it is new.

    Raises:
        InputError: If the folder cannot be written.
    """
    written = []
    contents = {
        entry.name: entry.read_text(encoding="utf-8")
        for entry in sorted(files("kinolab.cli.course").iterdir(), key=lambda entry: entry.name)
        if entry.name.endswith(".ipynb")
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # The requirements are for Binder and Colab.
        for name, text in {**contents, "requirements.txt": "kinolab[course]\n"}.items():
            path = folder / name
            written.append((path, not path.exists()))
            if not path.exists():
                path.write_text(text, encoding="utf-8")
    except OSError as error:
        what = f"cannot be written: {error.strerror or error}."
        raise InputError([Mistake(str(folder), what, "Name another folder.")]) from error
    return written
