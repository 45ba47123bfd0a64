"""In what a machine differs from the one that was asked for, where it moves otherwise.

A machine may be described in other words and move alike. So nothing here is a fault by itself: it
is what may explain one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.stability import random_states
from kinolab.testing.answers.asked_motion import state_for
from kinolab.testing.answers.judging import THREE_DIGITS, WrongAnswerError

HEAVY = (("mass", "kg"), ("largest moment of inertia", "kg m^2"))
NEAR = 1e-4  # [m], [rad]: where a body is, and how far it turns


def explanations(asked: PlanningTask, given: PlanningTask) -> Iterator[WrongAnswerError]:
    """Yield what may explain that a machine moves otherwise than it should: sentences."""
    yield from _gravity(asked, given)
    yield from _freedoms(asked, given)
    yield from _masses(asked, given)
    with suppress(KinolabError):  # where the machine cannot be as it should
        yield from _places(asked, given)


def _gravity(asked: PlanningTask, given: PlanningTask) -> Iterator[WrongAnswerError]:
    due, own = (_pull(task) for task in (asked, given))
    if not np.allclose(due, own, rtol=THREE_DIGITS):
        yield WrongAnswerError(f"gravity is {_vector(own)} m/s^2", _vector(due))


def _pull(task: PlanningTask) -> Array:
    system = task.system
    if system.gravity is None:
        return np.zeros(3)
    return np.array(system.gravity.down) * system.number(system.gravity.strength)


def _vector(values: Array) -> str:
    return f"({', '.join(f'{value:.4g}' for value in values + 0.0)})"


def _freedoms(asked: PlanningTask, given: PlanningTask) -> Iterator[WrongAnswerError]:
    due, own = (task.model.velocity_names for task in (asked, given))
    if len(due) != len(own):
        many = ", ".join(own) or "none"
        yield WrongAnswerError(
            f"the number of velocities that its constraints ({_constraints(given)}) leave free is "
            f"{len(own)} ({many})",
            f"{len(due)} ({', '.join(due) or 'none'}; constraints: {_constraints(asked)})",
        )


def _constraints(task: PlanningTask) -> str:
    return ", ".join(constraint.name for constraint in task.system.all_constraints) or "none"


def _masses(asked: PlanningTask, given: PlanningTask) -> Iterator[WrongAnswerError]:
    """Compare what bodies of the same name have of mass and of inertia."""
    due, own = (_heavy(task) for task in (asked, given))
    for name in due.keys() & own.keys():
        pairs = zip(HEAVY, due[name], own[name], strict=True)
        for (what, unit), right, found in pairs:
            if not np.isclose(right, found, rtol=THREE_DIGITS, atol=0.0):
                told = f"the {what} of {name} is {found:.4g} {unit}"
                yield WrongAnswerError(told, f"{right:.4g} {unit}")


def _heavy(task: PlanningTask) -> dict[str, tuple[float, float]]:
    system, told = task.system, {}
    for body in system.bodies:
        largest = float(np.linalg.eigvalsh(system.inertia_of(body))[-1])
        told[body.name] = system.number(body.mass), largest
    return told


def _places(asked: PlanningTask, given: PlanningTask) -> Iterator[WrongAnswerError]:
    """Compare where bodies of the same name are, and how they turn from the start to there."""
    common = [n for n in asked.model.coordinate_names if n in given.model.coordinate_names]
    if not common:
        return
    names = [[body.name for body in task.system.bodies] for task in (asked, given)]
    x = random_states(asked.model)[0]
    states = [(one, state_for(asked, given, one, common)[0]) for one in (asked.start, x)]
    at = ", ".join(f"{n} = {x[asked.model.state_names.index(n)]:.3g}" for n in common)
    rows = (np.array([pair[k] for pair in states]) for k in (0, 1))
    frames = [
        np.asarray(task.model.frames(one)).reshape(2, -1, 3, 4)
        for task, one in zip((asked, given), rows, strict=True)
    ]
    for name in (one for one in names[0] if one in names[1]):
        due, own = (f[:, n.index(name)] for f, n in zip(frames, names, strict=True))
        heavy, ours = (_tensor(t, name, f[0]) for t, f in ((asked, due), (given, own)))
        if not np.allclose(due[1, :, 3], own[1, :, 3], atol=NEAR):
            what = f"at {at} {name} is at {_vector(own[1, :, 3])} m"
            yield WrongAnswerError(what, f"{_vector(due[1, :, 3])} m")
        elif not np.allclose(_turn(due), _turn(own), atol=NEAR):
            yield WrongAnswerError(f"from the start to {at} {name} turns otherwise than it should.")
        elif _differ(*(np.asarray(np.linalg.eigvalsh(one), dtype=float) for one in (heavy, ours))):
            continue  # told with its mass
        elif _differ(heavy, ours):
            what = f"the moments of inertia of {name} about the world's x, y and z are at the start"
            told = f"{_vector(np.diag(ours))} kg m^2"
            yield WrongAnswerError(f"{what} {told}", f"{_vector(np.diag(heavy))} kg m^2")


def _tensor(task: PlanningTask, name: str, pose: Array) -> Array:
    """Return a body's inertia along the world's axes, shape (3, 3), in a pose (3, 4)."""
    system, turn = task.system, pose[:, :3]
    body = next(one for one in system.bodies if one.name == name)
    return np.asarray(turn @ system.inertia_of(body) @ turn.T)


def _differ(due: Array, own: Array) -> bool:
    return not np.allclose(due, own, rtol=0.0, atol=THREE_DIGITS * np.abs(due).max())


def _turn(frames: Array) -> Array:
    """Return by which rotation in the world a body gets from one pose to another, (2, 3, 4)."""
    turned: Array = frames[1, :, :3] @ frames[0, :, :3].T
    return turned
