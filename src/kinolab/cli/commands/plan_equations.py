"""``plan equations``: print the equations of motion of a machine."""

from __future__ import annotations

import click


@click.command("equations")
@click.argument("what")
@click.option("--latex", is_flag=True, help="Print LaTeX.")
def command(what: str, latex: bool) -> int:
    """Print the equations of motion of WHAT: a system, a scenario, or machine.py:function."""
    from kinolab.loading import find_machine

    equations = find_machine(what).equations()
    click.echo(equations.latex() if latex else equations.text())
    return 0
