"""Write docs/stable.txt, a line for everything that is promised to stay (docs/stability.md).

    python tools/write_stable.py [--check] [--drop]

With --check nothing is written: it names what is missing from the list, or gone from kinolab, and
returns 1 if there is anything. What is gone leaves the list with --drop alone.
"""

from __future__ import annotations

import argparse
import inspect
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import click
from pydantic import BaseModel
from write_reference import public_names

from kinolab.cli.front import plan
from kinolab.scenario.schema import Scenario
from kinolab.solve import EXIT_CODES

DOCS = Path(__file__).resolve().parents[1] / "docs"
LIST = DOCS / "stable.txt"
MODULES = (
    "kinolab",
    "kinolab.dynamics",
    "kinolab.gym",
    "kinolab.interchange",
    "kinolab.robots",
    "kinolab.systems",
    "kinolab.testing",
)


def promised() -> set[str]:
    """Return the lines of everything that kinolab has and promises."""
    return {*names(), *keys(Scenario, "", ()), *files(), *exit_codes(), *options(plan, "plan")}


def names() -> Iterator[str]:
    """Yield public names with the arguments that one may give them."""
    for module in map(import_module, MODULES):
        for name in public_names(module):
            thing, full = getattr(module, name), f"{module.__name__}.{name}"
            if inspect.ismodule(thing):
                continue
            yield f"name {full}{arguments(thing)}"
            if inspect.isclass(thing):
                members = inspect.getmembers(thing)
                own = (one for one in members if not one[0].startswith("_") and described(one[1]))
                yield from (f"name {full}.{member}{arguments(value)}" for member, value in own)


def described(thing: object) -> bool:
    """Say whether a member of a class is kinolab's own."""
    function = thing.fget if isinstance(thing, property) else thing
    return getattr(function, "__module__", "").startswith("kinolab")


def arguments(thing: Any) -> str:
    """Return the arguments of a call, with "=..." where one may be left out."""
    if not callable(thing):
        return ""
    try:
        parameters = inspect.signature(thing).parameters.values()
    except ValueError:  # of classes of other libraries
        return "(...)"
    empty = inspect.Parameter.empty
    plain = [
        p.replace(annotation=empty, default=p.default if p.default is empty else Left())
        for p in parameters
        if not p.name.startswith("_")
    ]
    return str(inspect.Signature(plain))


class Left:
    """What is left out."""

    def __repr__(self) -> str:
        """Return three dots."""
        return "..."


def keys(section: type[BaseModel], above: str, seen: tuple[type, ...]) -> Iterator[str]:
    """Yield the keys of a scenario, as paths."""
    for name, field in section.model_fields.items():
        path = f"{above}{field.alias or name}"
        yield f"key {path}"
        for inner in sections(field.annotation):
            if inner not in seen:
                yield from keys(inner, f"{path}.", (*seen, inner))


def sections(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the tables that a key may take."""
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from sections(argument)


def files() -> Iterator[str]:
    """Yield the files of a run and the columns and numbers in them, from their page."""
    text = (DOCS / "files.md").read_text(encoding="utf-8")
    for name in re.findall(r"^\| \[?`([^`]+)`", text.split("\n## ")[0], re.MULTILINE):
        yield f"file {name}"


def exit_codes() -> Iterator[str]:
    """Yield the exit codes of a plan."""
    yield from (f"exit {code} {status}" for status, code in EXIT_CODES.items())


def options(command: click.Command, called: str) -> Iterator[str]:
    """Yield a command and its options."""
    yield f"command {called}"
    if isinstance(command, click.Group):
        for name in command.list_commands(click.Context(command)):
            inner = command.get_command(click.Context(command), name)
            if inner is not None and not inner.hidden:
                yield from options(inner, f"{called} {name}")
        return
    for parameter in command.params:
        if isinstance(parameter, click.Option) and not parameter.hidden:
            yield from (f"command {called} {word}" for word in parameter.opts)


def main() -> int:
    """Write the list, or check it."""
    parser = argparse.ArgumentParser(description="Write docs/stable.txt.")
    parser.add_argument("--check", action="store_true", help="write nothing, name what differs")
    parser.add_argument("--drop", action="store_true", help="take out of the list what is gone")
    chosen = parser.parse_args()
    there, recorded = promised(), set(LIST.read_text(encoding="utf-8").splitlines())
    for sign, lines in (("gone", recorded - there), ("new", there - recorded)):
        sys.stdout.writelines(f"{sign}: {line}\n" for line in sorted(lines))
    if chosen.check:
        return int(there != recorded)
    kept = there if chosen.drop else there | recorded
    LIST.write_text("".join(f"{line}\n" for line in sorted(kept)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
