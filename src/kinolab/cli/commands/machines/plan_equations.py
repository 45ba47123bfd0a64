"""``plan equations``: print the equations of motion of a machine."""

from __future__ import annotations

import click

from kinolab.cli.terminal import say


@click.command("equations")
@click.argument("what")
@click.option("--latex", is_flag=True, help="Print LaTeX.")
def command(what: str, latex: bool) -> int:
    """Print the equations of motion of WHAT: a system, a scenario, or machine.py:function."""
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.loading import find_machine

    for title, machine in in_each_mode(find_machine(what)):
        if title:
            say(title)
        equations = machine.equations()
        say(equations.latex() if latex else equations.text())
    return 0
