"""Files of other tools that are read as scenarios, told by their endings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from kinolab.loading.tables import Read
from kinolab.scenario import read_scenario
from kinolab.scenario.dynobench import is_environment, read_environment


def is_foreign(source: str | Path) -> bool:
    """Whether a path is one of an environment of dynobench or a problem of OMPL.app."""
    return is_environment(source) or is_problem(source)


def is_problem(source: str | Path) -> bool:
    """Whether a path is one of a problem of OMPL.app."""
    return Path(source).suffix.lower() == ".cfg"


def read_any(source: str | Path, *, overrides: Sequence[str] = ()) -> Read:
    """Read a scenario of any kind, and list its mistakes instead of raising them.

    Args:
        source: A path, or the name of a built-in scenario.
        overrides: ``KEY=VALUE`` texts that replace keys.

    Raises:
        InputError: If there is no such file, or it is not what its ending says.
    """
    if is_environment(source):
        return read_environment(source, overrides=overrides)
    if is_problem(source):
        from kinolab.loading.omplapp_problem import read_problem_file  # late: few files are of it

        return read_problem_file(source, overrides=overrides)
    return read_scenario(source, overrides=overrides)
