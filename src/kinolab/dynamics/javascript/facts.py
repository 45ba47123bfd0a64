"""Metadata of a machine for its JavaScript: names, units, limits, initial state."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.model.units import state_units
from kinolab.numerics.arrays import finite_or_none
from kinolab.numerics.manifolds.state_parts import spheres_of


def facts_of(model: Model, derivation: Derivation) -> dict[str, Any]:
    """Return a machine's metadata as plain data; infinite limits are None."""
    system = model.system
    references = system.feedback.references if system.feedback else None
    return {
        "name": system.name,
        "stateNames": model.state_names,
        "stateUnits": state_units(model),
        "stateBounds": [[*map(finite_or_none, pair)] for pair in model.state_bounds.tolist()],
        "circular": model.circular.tolist(),
        "spheres": [[part.first, part.size] for part in spheres_of(derivation.parts)],
        "methods": {name: asdict(METHODS[name]) for name in model.methods},
        "rest": model.rest().tolist(),
        "parameters": [_parameter(system, entry.name, entry.unit) for entry in system.parameters],
        "inputs": _decided(system.inputs),
        "references": None if references is None else _decided(references),
        "bodies": [body.name for body in system.bodies],
        "cables": len(system.cables),
        "gravity": None if system.down is None else list(system.down),
        "requirements": [requirement.name for requirement in system.all_requirements],
    }


def as_json(data: Mapping[str, Any]) -> str:
    """Return data as JSON that is safe anywhere in JavaScript, inline scripts included."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _parameter(system: Mechanism, name: str, unit: str) -> dict[str, Any]:
    value = system.parameter_values[name]
    # 4.0: ratio of a slider's ends to the parameter's value
    ends = sorted((value / 4.0, value * 4.0)) if value else (-1.0, 1.0)
    return {"name": name, "unit": unit, "value": value, "lower": ends[0], "upper": ends[1]}


def _decided(entries: Sequence[Any]) -> list[dict[str, Any]]:
    found = []
    for entry in entries:
        lower, upper = bounds_of(entry)
        found.append({"name": entry.name, "unit": entry.unit, "lower": lower, "upper": upper})
    return found
