"""Roadmap files: plain arrays with fingerprints of the machine and the world."""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.files import write_whole
from kinolab.problem import PlanningTask
from kinolab.search.roadmap.roadmap import Roadmap
from kinolab.steering import cyclic_coordinates
from kinolab.untrusted import array_file


def fingerprints(problem: PlanningTask) -> dict[str, str]:
    """Return hashes of everything that the motions of a roadmap depend on, by kind."""
    from kinolab.dynamics.language.json.machine_file import machine_to_json

    world, integration = problem.world, problem.scenario.integration
    shapes = [array.tobytes() for o in world.obstacles for array in (o.vertices, o.faces)]
    solids = [
        (o.solid, o.primitive is None, *([o.ball] if o.ball else [])) for o in world.obstacles
    ]
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
        # Motions end anywhere in cyclic coordinates, which another goal may constrain.
        "relevance of coordinates": _hash(cyclic_coordinates(problem).tobytes()),
    }


def _hash(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(np.int64(len(part)).tobytes())
        digest.update(part)
    return digest.hexdigest()


VERSION = 1


def save_roadmap(path: Path, roadmap: Roadmap, problem: PlanningTask) -> None:
    """Write a roadmap atomically, with its fingerprints.

    Raises:
        InputError: If it cannot be written.
    """
    model = problem.model
    motions = list(roadmap.motions.values())
    out = io.BytesIO()
    tables: dict[str, Any] = {
        "version": VERSION,
        "state_names": np.array(model.state_names),
        "control_names": np.array(model.control_names),
        "milestones": np.array(roadmap.milestones, dtype=float).reshape(-1, model.nx),
        "pairs": np.array(list(roadmap.motions), dtype=np.int64).reshape(-1, 2),
        "steps": np.array([len(inputs) for inputs in motions], dtype=np.int64),
        "inputs": np.vstack([np.zeros((0, model.nu)), *motions]),
        **{f"of_{key}": np.array(value) for key, value in fingerprints(problem).items()},
    }
    np.savez_compressed(out, **tables)
    try:
        write_whole(path, out.getvalue())
    except OSError as error:
        what = f"the roadmap cannot be written ({error.strerror})."
        raise InputError([Mistake(str(path), what, "Name another file.")]) from error


def load_roadmap(path: Path, problem: PlanningTask) -> Roadmap:
    """Read a roadmap.

    Raises:
        InputError: If it cannot be read, or was made for another machine or world.
    """
    try:
        content = array_file(path)
        if content["version"].tolist() != VERSION:
            raise ValueError(f"its version is not {VERSION}")
        wanted = fingerprints(problem)
        changed = [key for key, value in wanted.items() if str(content[f"of_{key}"]) != value]
        if changed:
            verb = "has" if len(changed) == 1 else "have"
            what = f"the {' and the '.join(changed)} {verb} changed since this roadmap was made."
            remedy = "Its motions may not hold any more: name another file, or remove this one."
            raise InputError([Mistake(str(path), what, remedy)])
        return _roadmap(content, problem)
    except InputError:
        raise
    except Exception as error:  # a malformed file may raise anything
        what = f"it is no roadmap ({type(error).__name__}: {error})."
        raise InputError(
            [Mistake(str(path), what, "Name a file that does not exist yet.")]
        ) from error


def _roadmap(content: dict[str, np.ndarray], problem: PlanningTask) -> Roadmap:
    milestones, pairs, steps = (content[name] for name in ("milestones", "pairs", "steps"))
    inputs = content["inputs"]
    sound = (
        [table.dtype.kind for table in (milestones, inputs, pairs, steps)] == ["f", "f", "i", "i"]
        and milestones.shape[1:] == (problem.model.nx,)
        and inputs.shape == (steps.sum(), problem.model.nu)
        and pairs.shape == (*steps.shape, 2)
        and steps.min(initial=1) >= 1
        and pairs.min(initial=0) >= 0
        and pairs.max(initial=-1) < len(milestones)
        and all(np.isfinite(table).all() for table in (milestones, inputs))
    )
    if not sound:
        raise ValueError("its tables do not fit together")
    cuts = np.split(inputs, np.cumsum(steps)[:-1])
    motions = {(int(a), int(b)): rows for (a, b), rows in zip(pairs, cuts, strict=False)}
    return Roadmap(list(milestones), motions)
