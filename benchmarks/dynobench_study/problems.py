"""Which problems there are, and where their environments are."""

from __future__ import annotations

from pathlib import Path

from .published import published

FOLDERS = {"quadrotor_v0": "quad3d_v0", "quadrotor_v1": "quad3d_omplapp"}  # others: the machine's


def machine_of(problem: str) -> str:
    """Return the machine of a problem such as ``quadrotor_v0/window``."""
    folder = problem.partition("/")[0]
    return FOLDERS.get(folder, folder)


def all_problems() -> list[str]:
    """Return the names of the 43 problems in the order of the published table."""
    return list(published())


def chosen(problems: list[str] | None, machines: list[str] | None) -> list[str]:
    """Return the problems that were asked for, all where nothing was.

    Raises:
        ValueError: If nothing is called that.
    """
    known = all_problems()
    for kind, names, valid in (
        ("problem", problems, known),
        ("machine", machines, sorted({machine_of(name) for name in known})),
    ):
        unknown = [name for name in names or () if name not in valid]
        if unknown:
            what = f"no {kind} is called {', '.join(unknown)}."
            raise ValueError(f"{what} Known: {', '.join(valid)}.")
    return [
        name
        for name in known
        if name in (problems or known) and machine_of(name) in (machines or [machine_of(name)])
    ]


def environment(folder: Path, problem: str) -> Path:
    """Return the file of a problem.

    Args:
        folder: Where the benchmark keeps its environments.
        problem: Its name.
    """
    return folder / f"{problem}.yaml"
