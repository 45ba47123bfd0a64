"""``plan new``: write a commented machine and scenario to start from."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import click

from kinolab.cli.terminal import say
from kinolab.errors import InputError, Mistake

STARTERS = ("puck", "wheels", "arm", "flyer", "segway", "pick-and-place", "hopper")


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
    for path in write_starter(name, Path(), kind or "puck"):
        say(f"written {path}")
    say(f"next: plan {name}.toml")
    return 0


def write_starter(name: str, folder: Path, kind: str = "puck") -> list[Path]:
    """Write NAME.py and NAME.toml and return their paths.

    Args:
        name: Of the machine.
        folder: Where they go.
        kind: Of the machine: one of ``STARTERS``.

    Raises:
        InputError: If the name cannot be a function's, or a file exists already.
    """
    if not name.isidentifier():
        remedy = "Use letters, digits and underscores, beginning with a letter."
        raise InputError([Mistake(repr(name), "this cannot be the name of a machine.", remedy)])
    written = {folder / f"{name}.{ending}": ending for ending in ("py", "toml")}
    existing = [
        Mistake(str(path), "this file exists already.", "Choose another name.")
        for path in written
        if path.exists()
    ]
    if existing:
        raise InputError(existing)
    for path, ending in written.items():
        path.write_text(_text(kind, ending).replace("{name}", name), encoding="utf-8")
    return list(written)


def _text(kind: str, ending: str) -> str:
    """Return a text of ``cli/starters``; below the heading of wheels comes ``diff_drive``."""
    name = f"{kind.replace('-', '_')}.{'txt' if ending == 'py' else ending}"
    text = files("kinolab.cli.starters").joinpath(name).read_text(encoding="utf-8")
    if name == "wheels.txt":
        source = files("kinolab.systems").joinpath("diff_drive.py").read_text(encoding="utf-8")
        text += source.partition("\n")[2].replace("diff_drive", "{name}")
    return text
