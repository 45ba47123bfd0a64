"""``plan new``: write a commented machine and scenario to start from."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.terminal import say


@click.command("new")
@click.argument("name")
@click.option("--wheels", "kind", flag_value="wheels", help="A robot on two driven wheels.")
@click.option("--arm", "kind", flag_value="arm", help="An arm with two links.")
@click.option("--flyer", "kind", flag_value="flyer", help="A drone in a vertical plane.")
@click.option("--segway", "kind", flag_value="segway", help="A body that balances on two wheels.")
@click.option(
    "--pick-and-place", "kind", flag_value="pick-and-place", help="A hand that moves a block."
)
@click.option("--hopper", "kind", flag_value="hopper", help="A body that hops on a springy leg.")
def command(name: str, kind: str | None) -> int:
    """Write a commented machine NAME.py and a scenario NAME.toml to start from.

    Left alone, it is a puck on an air table.
    """
    from kinolab.scenario.starters.starter_files import write_starter

    for path in write_starter(name, Path(), kind or "puck"):
        say(f"written {path}")
    say(f"next: plan {name}.toml")
    return 0
