"""Description of planners, built-in, registered or from a file, for ``plan list``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from kinolab import planners
from kinolab.errors import InputError, KinolabError, UnknownNameError
from kinolab.scenario.user_code import python_reference
from kinolab.search import AbstractPlanner, plugins
from kinolab.settings import Setting, settings_of


@dataclass(frozen=True)
class PlannerEntry:
    """Description of a planner.

    Attributes:
        name: What a scenario writes after [planner] name =.
        summary: The first line of its docstring; may be empty.
        source: The literature that it cites; may be empty.
        origin: The file or the package that it comes from; empty for kinolab's own.
        settings: All of them.
        fault: Why it cannot be used; empty if it can.
    """

    name: str
    summary: str = ""
    source: str = ""
    origin: str = ""
    settings: tuple[Setting, ...] = ()
    fault: str = ""

    @property
    def line(self) -> str:
        """Its summary, or why it cannot be used."""
        return f"cannot be used: {self.fault}" if self.fault else self.summary


def planner_entries(wanted: Sequence[str] = ()) -> list[PlannerEntry]:
    """Return descriptions of planners; those that cannot be used say why.

    Args:
        wanted: Names, or ``file.py:Class`` with paths from the working folder, whose files are run;
            every registered planner if left out.

    Raises:
        InputError: If there is no planner of a name, or a file has no such planner.
    """
    return [entry for name in wanted or planners.names() for entry in _entries_of(name)]


def option_entries(wanted: Sequence[str] = ()) -> list[PlannerEntry]:
    """Return descriptions of the options of trajectory optimisation, with their values.

    Args:
        wanted: Names of option groups; all if left out.

    Raises:
        UnknownNameError: If there is no group of a name.
    """
    from kinolab.trajopt.nlp.options import OPTIONS  # late: the optimiser is slow to import

    for name in wanted:
        if name not in OPTIONS:
            raise UnknownNameError("option", name, known=OPTIONS)
    found = []
    for name in wanted or OPTIONS:
        options, entry = OPTIONS[name], _about(type(OPTIONS[name]), name, "")
        own = (replace(item, default=getattr(options, item.name)) for item in entry.settings)
        found.append(replace(entry, settings=tuple(own)))
    return found


def _entries_of(name: str) -> Iterator[PlannerEntry]:
    """Yield kinolab's planner of a name and the one that packages register, or that of a file."""
    own, registered = planners.built_in(), plugins.registered().get(name, [])
    if name in own:
        yield _entry(name, "", partial(planners.get, name))
    if registered:
        origin = ", ".join(dict.fromkeys(map(plugins.package_of, registered)))
        yield _entry(name, origin, partial(plugins.class_of, registered, "", own))
    if name not in own and not registered:
        file, _ = python_reference(name) or ("", "")
        yield _about(planners.get(name, where=""), name, file)


def _entry(name: str, origin: str, find: Callable[[], type[AbstractPlanner]]) -> PlannerEntry:
    """Return the description of a planner; one that cannot be loaded must not hide others."""
    try:
        return _about(find(), name, origin)
    except InputError as error:
        reasons = (f"{mistake.what} {mistake.remedy}".rstrip() for mistake in error.mistakes)
        return PlannerEntry(name, origin=origin, fault=" ".join(reasons))
    except KinolabError as error:
        return PlannerEntry(name, origin=origin, fault=str(error))


def _about(planner: type, name: str, origin: str) -> PlannerEntry:
    paragraphs = [" ".join(text.split()) for text in _description(planner).split("\n\n")]
    sources = [text for text in paragraphs if text.startswith("Source:")]
    source = " ".join(sources).removeprefix("Source:").strip()
    summary = _description(planner).strip().partition("\n")[0]
    return PlannerEntry(name, summary, source, origin, settings_of(planner))


def _description(planner: type) -> str:
    """Return a class's own docstring, not the signature that dataclasses generate."""
    text = vars(planner).get("__doc__") or ""
    return "" if text.startswith(f"{planner.__name__}(") else inspect.cleandoc(text)
