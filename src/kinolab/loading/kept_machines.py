"""The machine of a scenario and its limits, from the cache where nothing of it has changed.

To describe a machine, Python builds expressions. What was described once is found again by all that
it came from: kinolab's own code, if the machine is registered; the text, if it is in a JSON file;
and the values of parameters. A user's Python file may read whatever it likes, so what is in one is
always described anew.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.facts.machine_facts import MachineFacts, facts_of
from kinolab.dynamics.language.json.machine_folder import texts_of
from kinolab.errors import InputError, Mistake
from kinolab.lazy import versions_of
from kinolab.loading.find import find_system
from kinolab.scenario import Scenario
from kinolab.store import code_in

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism

Limits = dict[str, tuple[float, float]]


class ScenarioMachine:
    """The machine that a scenario names; the scenario need not fit it.

    Attributes:
        facts: What there is to know before its equations of motion are derived.

    Raises:
        InputError: If the machine does not exist, or describing it fails.
    """

    facts: MachineFacts

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._content = scenario, content_of(scenario)
        self._kept: Model | None = None
        if self._content is not None:
            self._kept = Model.kept(self._content, partial(_with_law, scenario))
        if self._kept is None:
            self._system = find_system(scenario)
            self.facts = facts_of(self._system)
        else:
            self.facts = self._kept.machine

    def quasi_velocities(self) -> tuple[str, ...]:
        """Return the names of velocities that are no rates, without deriving what follows."""
        if self._kept is not None:
            return tuple(entry.name for entry in self._kept.quasi_velocities)
        from kinolab.dynamics.derivation.velocity_coordinates import chosen_quasi_velocities

        try:
            return tuple(entry.name for entry in chosen_quasi_velocities(self._system))
        except InputError:
            return ()  # the derivation will say what is wrong

    def model(self) -> Model:
        """Return its equations of motion, its regulator designed.

        Raises:
            InputError: If they cannot be derived, or its flat map does not hold.
        """
        if self._kept is not None:
            return self._kept
        model = self._system.model()
        if model.machine.flat is not None:
            from kinolab.dynamics.analysis.flat.given_map import check_flat_map

            check_flat_map(model)
        if self._content is not None:
            model.keep(self._content)
            model.keep(_content_of_texts(model.files, self._scenario))  # a run's, checked later
        return model


def with_limits(model: Model, limits: Limits) -> Model:
    """Return a machine with narrower limits of its inputs or references, by their names.

    Raises:
        InputError: Where limits do not intersect those of the machine.
    """
    content = json.dumps([model.key, "limited", sorted(limits.items())])
    return Model.described_by(content, partial(_limited, model, limits))


def content_of(scenario: Scenario) -> str | None:
    """Return all that a scenario's machine is described by, as text; None where it may be more."""
    section = scenario.system
    if scenario.origin.machine is not None:
        return None  # which has a place in the cache of its own, by its text
    if section.machines is not None:
        own = {
            name: content_of(scenario.model_copy(update={"system": one}).located(scenario.origin))
            for name, one in section.machines.items()
        }
        return None if None in own.values() else _content("side by side", own)
    if section.name in systems.names():
        return _content("registered", section.name, systems_code(), section.parameters)
    if section.file is None or not section.file.endswith(".json"):
        return None
    try:
        return _content_of_texts(texts_of(scenario.folder / section.file), scenario)
    except (OSError, UnicodeDecodeError):
        return None  # loading it will say what is wrong


def _content_of_texts(texts: dict[str, str], scenario: Scenario) -> str:
    return _content("texts", texts, scenario.system.parameters)


def _content(*parts: Any) -> str:
    # machines are described and regulators designed with them
    return json.dumps([*parts, *versions_of("sympy", "numpy", "scipy").values()], sort_keys=True)


def systems_code() -> str:
    """Return a digest of the code that describes registered machines.

    That is all that they may import, but for ``kinolab.dynamics``, which the cache adds.
    """
    package = Path(systems.__file__).parents[1]
    return code_in(package / "systems", package / "numerics", *sorted(package.glob("*.py")))


def _with_law(scenario: Scenario) -> Mechanism:
    from kinolab.dynamics.analysis.lqr_design import with_law

    return with_law(find_system(scenario))


def _limited(model: Model, limits: Mapping[str, tuple[float, float]]) -> Mechanism:
    """Return a machine with narrower limits of inputs or references.

    Args:
        model: The machine; a regulator's gains are designed for its original limits.
        limits: (lower, upper) by name of the input or reference; others are ignored.

    Raises:
        InputError: Where limits do not intersect those of the machine.
    """
    from kinolab.dynamics.language.feedback import (
        Feedback,
    )  # which a kept machine does not need
    from kinolab.dynamics.language.inputs import bounds_of

    system = model.system
    mistakes: list[Mistake] = []

    def held(entry: Any) -> Any:
        if entry.name not in limits:
            return entry
        lower, upper = bounds_of(entry)
        least, most = max(lower, limits[entry.name][0]), min(upper, limits[entry.name][1])
        if not least < most:
            what = f"the limits of {entry.name} exclude each other: {least:g} to {most:g}."
            mistakes.append(Mistake(entry.name, what, f"The machine's are {lower:g} to {upper:g}."))
        return replace(entry, limit=(least, most))

    inputs, feedback = [held(entry) for entry in system.inputs], system.feedback
    if isinstance(feedback, Feedback):
        feedback = Feedback([held(entry) for entry in feedback.references], feedback.law)
    if mistakes:
        raise InputError(mistakes)
    return system.changed(inputs=inputs, feedback=feedback)
