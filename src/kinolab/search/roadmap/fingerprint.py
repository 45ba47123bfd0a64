"""What a roadmap is good for: one machine, in one world, with one set of limits."""

from __future__ import annotations

import hashlib

import numpy as np

from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import Problem
from kinolab.steering import cyclic_coordinates


def fingerprints(problem: Problem) -> dict[str, str]:
    """Return a hash of everything that the motions of a roadmap rest on, by what it is."""
    world, integration = problem.world, problem.scenario.integration
    shapes = [array.tobytes() for o in world.obstacles for array in (o.vertices, o.faces)]
    solids = [(o.solid, o.primitive is None) for o in world.obstacles]
    limits = [problem.bounds.tobytes(), problem.rate_bounds.tobytes()]
    return {
        "machine": _hash(machine_to_json(problem.system).encode()),
        "world": _hash(
            *shapes, repr((solids, world.ground, sorted(world.bounds.items()))).encode()
        ),
        "limits": _hash(*limits, repr(problem.keep_outs).encode()),
        "integration": _hash(
            repr(
                (integration.step, integration.substeps, integration.truth, integration.method)
            ).encode()
        ),
        # Motions end anywhere in what is ignorable, which a goal may not be content with.
        "relevance of coordinates": _hash(cyclic_coordinates(problem).tobytes()),
    }


def _hash(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(np.int64(len(part)).tobytes())
        digest.update(part)
    return digest.hexdigest()
