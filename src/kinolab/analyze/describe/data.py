"""A machine's description as plain data, for ``plan describe --json``."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from kinolab.analyze.describe.controllability import sentences
from kinolab.analyze.describe.decoupling import Decoupling
from kinolab.analyze.describe.description import Description
from kinolab.dynamics.analysis.fields.linear_controllability import LinearControllability
from kinolab.dynamics.analysis.fields.small_time import SmallTimeVerdict
from kinolab.dynamics.analysis.flatness_of import FlatnessFound
from kinolab.dynamics.facts.machine_facts import CoordinateFacts
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.problem.warnings import machine_warnings


def description_to_json(found: Description) -> dict[str, Any]:
    """Return a description as one JSON object."""
    closure = found.closure
    return {
        "name": found.name,
        "configuration_space": found.space,
        "dimension": found.dimension,
        "degrees_of_freedom": found.freedom,
        "states": found.states.dimension,
        "stored_numbers": found.states.stored,
        "further_states": list(found.states.further),
        "velocities": [{"name": name, "what": what} for name, what in found.velocities],
        "singular": found.singular or None,
        "bodies": [asdict(body) for body in found.bodies],
        "constraints": [asdict(constraint) for constraint in found.constraints],
        "integrable_combinations": list(closure.combinations) if closure else [],
        "integrals": [str(integral) for integral in closure.integrals] if closure else [],
        "watched_pairs": [list(pair) for pair in found.watched],
        "cyclic_coordinates": list(found.cyclic),
        "conserved_momenta": list(found.conserved),
        "conserved_totals": list(found.momenta),
        "flat_outputs": [one.said for one in found.flat.outputs] if found.flat else [],
        "flatness": None if found.flat is None else _flatness(found.flat),
        "decoupling_fields": _decoupling(found.decoupling),
        "coordinates": [_coordinate(one) for one in found.machine.coordinates],
        "inputs": [_input(entry) for entry in found.inputs],
        "parameters": dict(found.machine.parameters),
        "parameter_units": dict(found.units),
        "offered_parameters": [asdict(one) for one in found.machine.offered],
        "requirements": [one.name for one in found.machine.requirements],
        "warnings": list(machine_warnings(found.machine)),
        "growth_vector": list(closure.growth) if closure else None,
        "accessible": {
            "growth": list(found.accessible.growth),
            "dimension": found.accessible.dimension,
            "full": found.accessible.full,
            "complete": found.accessible.complete,
            "inputs_are_states": found.prolonged,
        },
        "rests": [
            {
                "state": rest.state,
                "held": rest.held,
                "linear": _linear(rest.linear),
                "small_time": _small_time(rest.small_time),
            }
            for rest in found.rests
        ],
        "controllability": list(sentences(found)),
        "modes": [asdict(mode) for mode in found.generalisations],
        "left_out": list(found.left_out),
    }


def _flatness(found: FlatnessFound) -> dict[str, Any]:
    return {
        "verdict": found.flatness.value,
        "sentence": str(found),
        "outputs": [
            {"name": one.said, "formula": str(one.expression), "derivatives": one.order}
            for one in found.outputs
        ],
        "given": found.given,
        "left_over": list(found.left_over),
        "neglected": list(found.neglected),
    }


def _coordinate(one: CoordinateFacts) -> dict[str, Any]:
    *limits, speed = (value if isfinite(value) else None for value in (*one.limits, one.speed))
    return {"name": one.name, "unit": one.unit, "limits": limits, "speed": speed}


def _decoupling(found: Decoupling | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "moved": {name: list(moved) for name, moved in found.moved.items()},
        "growth": list(found.growth),
        "dimension": found.dimension,
        "kinematically_controllable": found.controllable,
        "damped": list(found.damped),
        "together": found.together,
    }


def _input(entry: Input) -> dict[str, Any]:
    lower, upper = bounds_of(entry)
    kind = type(entry).__name__.lower()
    return {"name": entry.name, "kind": kind, "unit": entry.unit, "limits": [lower, upper]}


def _linear(linear: LinearControllability) -> dict[str, Any]:
    return {
        "rank": linear.rank,
        "dimension": linear.dimension,
        "controllable": linear.controllable,
        "stabilisable": linear.stabilisable,
        "not_moved": list(linear.directions),
        "modes": [[mode.real, mode.imag] for mode in linear.modes],
    }


def _small_time(verdict: SmallTimeVerdict | None) -> dict[str, Any] | None:
    if verdict is None:
        return None
    return {
        "controllable": verdict.controllable,
        "outcome": verdict.outcome.name.lower(),
        "degree": verdict.degree,
        "obstacle": list(verdict.obstacle) if verdict.obstacle else None,
    }
