"""Find what a user names: a scenario, or a machine that is registered or in a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from kinolab import systems
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.scenario import (
    Scenario,
    builtin_scenarios,
    load_scenario,
    place_at,
    scenario_from,
    sound,
)
from kinolab.scenario.dynobench import is_environment, read_environment
from kinolab.scenario.user_code import blamed, run_file

if TYPE_CHECKING:  # a machine that is in the cache needs no symbols
    from kinolab.dynamics import System


def find_scenario(what: str, *, overrides: Sequence[str] = ()) -> Scenario:
    """Return the scenario that a text names, or an empty world for the machine that it names.

    Args:
        what: A scenario (name or path), a system's name, or ``machine.py:function``.
        overrides: ``KEY=VALUE`` texts that replace keys.

    Raises:
        InputError: If nothing has this name, or it has mistakes.
    """
    scenario = _named_scenario(what, overrides)
    if scenario is not None:
        return scenario
    system = find_machine(what)  # says what exists, where nothing has this name
    source = {"name": what} if what in systems.names() else {"file": _with_function(what)}
    document = {"schema": 1, "title": f"{system.name} by itself", "system": source}
    return scenario_from(document, Path(f"{system.name}.toml"), overrides=overrides)


def find_machine(what: str) -> System:
    """Return the machine that a text names.

    Args:
        what: A system's name, a scenario (name or path), or ``machine.py:function``, the function
            being named like the file where it is left out.

    Raises:
        InputError: If nothing has this name, naming the systems and scenarios there are.
    """
    if what in systems.names():
        return systems.get(what)
    if what.endswith((".py", ".json")) or what.rpartition(":")[0].endswith(".py"):
        return _system_in_file(Path(), _with_function(what), what)
    scenario = _named_scenario(what)
    if scenario is None:
        known = {*systems.names(), *builtin_scenarios()}
        raise UnknownNameError("system or scenario", what, known=known)
    return find_system(scenario)


def find_system(scenario: Scenario) -> System:
    """Return the machine of a scenario: a registered one, a user's, or one from a file.

    Raises:
        InputError: If it does not exist, or a parameter of it does not.
    """
    section = scenario.system
    if scenario.origin.machine is not None:
        system = scenario.origin.machine
    elif section.name is not None:
        if section.name not in systems.names():
            where = place_at(("system", "name"), scenario.origin)
            raise UnknownNameError("system", section.name, known=systems.names(), where=where)
        system = systems.get(section.name)
    else:
        where = place_at(("system", "file"), scenario.origin)
        system = _system_in_file(scenario.folder, str(section.file), where)
    known = [parameter.name for parameter in system.parameters]
    if all(name in known for name in section.parameters):
        return system.with_parameters(**section.parameters)
    return system  # the unknown ones are reported with all other names


def _named_scenario(what: str, overrides: Sequence[str] = ()) -> Scenario | None:
    """Return the scenario that a text names, None where it can only name a machine."""
    if is_environment(what):
        return sound(*read_environment(what, overrides=overrides))
    if what.endswith(".toml") or what in builtin_scenarios():
        return load_scenario(what, overrides=overrides)
    return None


def _with_function(what: str) -> str:
    """Complete ``machine.py`` by the function of its name."""
    return f"{what}:{Path(what).stem}" if what.endswith(".py") else what


def _system_in_file(folder: Path, text: str, where: str) -> System:
    """Return the system in a JSON file, or the one that ``machine.py:function`` makes."""
    from kinolab.dynamics import System
    from kinolab.dynamics.language.json.machine_file import load_machine

    if text.endswith(".json"):
        path = folder / text
        if not path.is_file():
            raise InputError([Mistake(where, f"there is no file {text}.")])
        return System.of(load_machine(path))
    file, _, function = text.rpartition(":")
    return _system_from_python(folder / file, function, where)


def _system_from_python(path: Path, function: str, where: str) -> System:
    from kinolab.dynamics import System

    module = run_file(path, where)
    factory = getattr(module, function, None)
    if not callable(factory):
        known = sorted(
            name
            for name, value in vars(module).items()
            if callable(value) and getattr(value, "__module__", None) == module.__name__
        )
        raise UnknownNameError(f"function of {path.name}", function, known=known, where=where)
    with blamed(f"running {function}() of {path.name}", where, path.resolve()):
        system = factory()
    if not isinstance(system, System):
        what = f"{function}() returned {type(system).__name__}, not a System."
        raise InputError([Mistake(where, what)])
    return system
