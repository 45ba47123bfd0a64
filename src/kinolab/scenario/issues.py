"""A mistake in a scenario before it has an address, and the place that scenario came from."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from kinolab.dynamics.facts.machine_facts import member_of

if TYPE_CHECKING:
    from kinolab.dynamics import System

KeyPath = tuple[str | int, ...]  # keys from the top of the document; lists count from 0


@dataclass(frozen=True)
class Issue:
    """One thing that is wrong at ``path``."""

    path: KeyPath
    what: str
    remedy: str = ""


@dataclass(frozen=True)
class Override:
    """One ``--set KEY=VALUE``: its text as it was typed, the path, and what stood there before.

    Changes from Python are overrides, too: of ``replace`` and ``with_obstacle``, as ``by`` says.
    """

    text: str
    path: KeyPath
    before: object = None
    by: str = "--set"

    @property
    def where(self) -> str:
        """How mistakes name it."""
        return f"{self.by} {self.text}".rstrip()

    def touches(self, path: KeyPath) -> bool:
        """Whether what stands at ``path`` was written by it, in whole or in part."""
        shared = min(len(path), len(self.path))
        return shared > 0 and path[:shared] == self.path[:shared]


@dataclass(frozen=True)
class Origin:
    """Where a scenario was read; no part of what it says, so all origins compare equal.

    Attributes:
        file: Its path, below whose folder relative paths start.
        overrides: What was changed since it was read.
        machine: The machine, where Python gave it as an object; [system] then names none.
        notes: Sentences on what was read otherwise than a file says it.
        machines: The names of the [[machine]] tables, in their order.
    """

    file: Path = field(default=Path("scenario.toml"), compare=False)
    overrides: tuple[Override, ...] = field(default=(), compare=False)
    machine: System | None = field(default=None, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    machines: tuple[str, ...] = field(default=(), compare=False)

    def written(self, path: KeyPath) -> KeyPath:
        """Return where it was written what stands at a path, of which machines have their own."""
        name = member_of(str(path[1]), self.machines) if path[1:] else ""
        if not name or path[0] not in ("start", "goal", "bounds", "metric"):
            return path
        own = str(path[1]).removeprefix(f"{name}_")
        return ("machine", self.machines.index(name), path[0], own, *path[2:])
