"""Find what a user names: a scenario, or a machine that is registered or in a file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab import systems
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.files import is_file
from kinolab.loading.foreign_files import is_foreign, read_any
from kinolab.scenario import (
    Scenario,
    SystemSection,
    builtin_scenarios,
    load_scenario,
    place_at,
    scenario_from,
    sound,
)
from kinolab.scenario.user_code import blamed, python_reference, run_file
from kinolab.scenario.values import ROBOT_FORMATS, ROBOT_ONLY

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
    folder, source = Path(), {"name": what}
    if what not in systems.names():
        folder, source = Path(what).parent, {"file": Path(what).name}
    document = {"schema": 1, "title": f"{system.name} by itself", "system": source}
    scenario = scenario_from(document, folder / f"{system.name}.toml", overrides=overrides)
    if what.endswith(ROBOT_FORMATS) and scenario.system == SystemSection(file=source["file"]):
        return scenario.located(replace(scenario.origin, machine=system))  # it is read once
    return scenario


def find_machine(what: str) -> System:
    """Return the machine that a text names.

    Args:
        what: A system's name, a scenario (name or path), or ``machine.py:function``; left out, the
            function is the one that makes a machine, or of several the one named like the file.

    Raises:
        InputError: If nothing has this name, naming the systems and scenarios there are.
    """
    if what in systems.names():
        return systems.get(what)
    if what.endswith((".py", ".json", *ROBOT_FORMATS)) or what.rpartition(":")[0].endswith(".py"):
        return _system_in_file(Path(), what, what)
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
    elif section.machines is not None:
        from kinolab.dynamics import System
        from kinolab.dynamics.together import together

        system = System.of(together(_machines(scenario)))
    elif section.name is not None:
        if section.name not in systems.names():
            where = place_at(("system", "name"), scenario.origin)
            raise UnknownNameError("system", section.name, known=systems.names(), where=where)
        system = systems.get(section.name)
    else:
        where = place_at(("system", "file"), scenario.origin)
        system = _system_in_file(scenario.folder, str(section.file), where, section)
    known = [*system.offered, *(parameter.name for parameter in system.parameters)]
    if all(name in known for name in section.parameters):
        return system.with_parameters(**section.parameters)
    return system  # the unknown ones are reported with all other names


def _machines(scenario: Scenario) -> dict[str, System]:
    """Return the machines of a scenario that has several, each with its parameters and its law."""
    from kinolab.dynamics.analysis.lqr_design import with_law

    return {
        name: with_law(
            find_system(scenario.model_copy(update={"system": section}).located(scenario.origin))
        )
        for name, section in (scenario.system.machines or {}).items()
    }


def file_of_machine(scenario: Scenario) -> Path | None:
    """Return the Python file that describes a scenario's machine; None where there is none."""
    section = scenario.system
    if section.name is not None:
        return Path(inspect.getfile(systems.maker(section.name)))
    file = scenario.folder / str(section.file).rpartition(".py")[0]
    return file.with_name(f"{file.name}.py") if ".py" in str(section.file) else None


def names_scenario(what: str) -> bool:
    """Whether a text names a scenario, or a problem in a file of another tool; not a machine."""
    return is_foreign(what) or what.endswith(".toml") or what in builtin_scenarios()


def _named_scenario(what: str, overrides: Sequence[str] = ()) -> Scenario | None:
    """Return the scenario that a text names, None where it can only name a machine."""
    if is_foreign(what):
        return sound(*read_any(what, overrides=overrides))
    if names_scenario(what):
        return load_scenario(what, overrides=overrides)
    return None


def _system_in_file(
    folder: Path, text: str, where: str, section: SystemSection | None = None
) -> System:
    """Return the system in a file of data, or the one that ``machine.py:function`` makes."""
    from kinolab.dynamics import System
    from kinolab.dynamics.language.json.machine_file import load_machine

    if text.endswith(".json"):
        path = folder / text
        if not is_file(path):
            raise InputError([Mistake(where, f"there is no file {text}.")])
        return System.of(load_machine(path))
    if text.endswith(ROBOT_FORMATS):
        from kinolab.robots import read_mjcf, read_urdf

        given = section.model_dump(exclude_none=True) if section else {}
        kept = {key: given[key] for key, *_ in ROBOT_ONLY if key in given}
        return (read_mjcf if text.endswith(".xml") else read_urdf)(folder / text, **kept)
    file, function = python_reference(text) or (text, "")
    return _system_from_python(folder / file, function, where)


def _system_from_python(path: Path, function: str, where: str) -> System:
    from kinolab.dynamics import System

    module = run_file(path, where)
    own = {
        name: value
        for name, value in vars(module).items()
        if callable(value) and getattr(value, "__module__", None) == module.__name__
    }
    function = function or _maker(own, path, where)
    factory = getattr(module, function, None)
    if not callable(factory):
        known = sorted(own)
        raise UnknownNameError(f"function of {path.name}", function, known=known, where=where)
    with blamed(f"running {function}() of {path.name}", where, path.resolve()):
        system = factory()
    if not isinstance(system, System):
        what = f"{function}() returned {type(system).__name__}, not a System."
        raise InputError([Mistake(where, what, "End it with return System(…).")])
    return system


def _maker(own: Mapping[str, Callable[..., Any]], path: Path, where: str) -> str:
    """Return the name of the function of a file that makes its machine, without calling any.

    Those whose annotations say that they return a System come first, then all without arguments.

    Args:
        own: What is defined in the file and can be called, by name.
        path: Of the file; of several functions, the one of its name is meant.
        where: What mistakes are reported for.

    Raises:
        InputError: If there is none, or several.
    """
    makers = [
        name
        for name, made in own.items()
        if inspect.isfunction(made) and name[0] != "_" and not _required(made)
    ]
    said = [name for name in makers if _returns_system(own[name])]
    found = said or makers
    if path.stem in found:
        return path.stem
    if len(found) == 1:
        return found[0]
    if found:
        what = f"several functions of {path.name} may make the machine: {', '.join(found)}."
        raise InputError([Mistake(where, what, f"Name one, such as {path.name}:{found[0]}.")])
    what = f"no function of {path.name} makes a machine."
    raise InputError([Mistake(where, what, "Write one without arguments that returns a System.")])


def _required(function: Callable[..., Any]) -> bool:
    """Whether a function cannot be called without arguments."""
    parameters = inspect.signature(function).parameters.values()
    optional = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return any(p.default is p.empty and p.kind not in optional for p in parameters)


def _returns_system(function: Callable[..., Any]) -> bool:
    said = function.__annotations__.get("return", "")
    return getattr(said, "__name__", str(said)).rpartition(".")[2] == "System"
