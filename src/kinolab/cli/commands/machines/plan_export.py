"""``plan export``: write a machine's equations of motion in another language."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.terminal import say


@click.command("export")
@click.argument("what")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    default=Path(),
    help="Folder of the files; by default this one.",
)
def command(what: str, out: Path) -> int:
    """Write the equations of motion of WHAT as C source, with a test.

    WHAT is a system, a scenario, a robot's file or machine.py:function. The source needs a C99
    compiler and no library but the standard one; the test compares it with kinolab's own results.
    """
    from kinolab.files import utf_8, write_whole
    from kinolab.loading import find_machine

    files = find_machine(what).to_c()
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        write_whole(out / name, utf_8(text))
        say(f"  written to {out / name}")
    source, test = (name for name in files if name.endswith(".c"))
    say(f"cc -O2 -ffp-contract=off {source} {test} -lm -o test && ./test")
    return 0
