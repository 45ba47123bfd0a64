"""Whether a machine moves as the one that was asked for: the same starts, the same inputs.

What is compared are coordinates, by their names. Which velocities are states, what a machine is
built of and how its further coordinates are counted is left to whoever describes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinolab.dynamics.model.units import state_units
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.simulation.stability import random_states
from kinolab.testing.answers.judging import THREE_DIGITS, WrongAnswerError

SPAN, STEPS = 0.5, 10  # [s] of each motion, and into how many it is divided
PUSH = 0.5  # of an input's limit; of one without a limit in its unit


@dataclass(frozen=True)
class Trial:
    """A motion that is compared.

    Attributes:
        kind: Of several of which one is told.
        how: What is done, in words.
        x: Where it starts, shape (nx,).
        u: Inputs, held for all of it, shape (nu,).
    """

    kind: str
    how: str
    x: Array
    u: Array


def differences(asked: PlanningTask, given: PlanningTask) -> list[WrongAnswerError]:
    """Return how a machine moves otherwise than the one that was asked for; empty if it does not.

    Args:
        asked: Provides the machine that was asked for, its start and the coordinates of its goal.
        given: What was handed in.
    """
    aims = _aims(asked)
    if missing := [name for name in aims if name not in given.model.coordinate_names]:
        named = ", ".join(given.model.coordinate_names)
        return [WrongAnswerError(f"it has no coordinate {', '.join(missing)}; it has {named}.")]
    if len(asked.model.control_names) != len(given.model.control_names):
        names = [", ".join(one.model.control_names) or "none" for one in (given, asked)]
        return [WrongAnswerError(f"its inputs are {names[0]}", names[1])]
    common = [n for n in asked.model.coordinate_names if n in given.model.coordinate_names]
    found = _compared(asked, given, common)
    # its further coordinates may be counted in another way, such as from another frame
    return found if found and (set(common) == set(aims) or _compared(asked, given, aims)) else []


def _aims(task: PlanningTask) -> list[str]:
    """Return the coordinates that start and goal of an exercise name; all if they name none."""
    names = task.model.coordinate_names
    indices = [i for i in task.goal.indices if i < len(names)]
    told = {*(names[i] for i in indices), *task.scenario.start}
    return [name for name in names if name in told] or list(names)


def _compared(
    asked: PlanningTask, given: PlanningTask, names: Sequence[str]
) -> list[WrongAnswerError]:
    """Return the first difference of each kind of motion."""
    found: dict[str, WrongAnswerError] = {}
    for trial in _trials(asked):
        if trial.kind not in found:
            for difference in _difference(asked, given, trial, names):
                found[trial.kind] = difference
                break
    return list(found.values())


def _trials(asked: PlanningTask) -> Iterator[Trial]:
    """Yield what is tried: let go, pushed by each input, in motion under all of them."""
    model = asked.model
    generator, idle = np.random.default_rng(5), model.null_control()
    moving = np.vstack([asked.start, random_states(model)[:3]])  # at random, besides the start
    resting = moving.copy()
    resting[:, model.speeds] = 0.0
    for x in resting:
        yield Trial("rest", "let go at rest", x, idle)
    most = np.where(np.isfinite(model.control_bounds[:, 1]), model.control_bounds[:, 1], 1.0)
    for k, name in enumerate(model.control_names):
        u = idle.copy()
        u[k] = PUSH * most[k]
        for x in resting:
            yield Trial(name, f"at rest, under {name} = {u[k]:.3g}", x, u)
    for x in moving[1:]:
        u = PUSH * most * generator.uniform(0.0, 1.0, model.nu)
        yield Trial("motion", "in motion", x, u)


def _difference(
    asked: PlanningTask, given: PlanningTask, trial: Trial, names: Sequence[str]
) -> Iterator[WrongAnswerError]:
    """Yield how a trial differs, if it does."""
    there = [asked.model.state_names.index(name) for name in names]
    u = _inputs_for(asked, given, trial.u)
    try:
        right = _moved(asked, trial.x, trial.u)[:, there]
    except KinolabError:
        return  # the limits of what was asked for
    at = ", ".join(f"{n} = {trial.x[i]:.3g}" for n, i in zip(names, there, strict=True))
    try:
        y, off = state_for(asked, given, trial.x, names)
        here = [given.model.state_names.index(name) for name in names]
        moved = _moved(given, y, u)[:, here]
    except KinolabError as error:
        told = " ".join(str(error).split())
        yield WrongAnswerError(f"{trial.how} at {at}, it cannot be simulated: {told}")
        return
    if off is not None:
        name, rate, wanted = off
        told = f"moved as it should at {at}, the rate of {name} is {rate:.4g}"
        yield WrongAnswerError(told, wanted)
        return
    sizes, units = asked.scales[there], state_units(asked.model)
    changes, dues = (moved - moved[0]) / sizes, (right - right[0]) / sizes
    largest = np.abs(dues).max(axis=0)
    # 0.01 of the largest change of a coordinate in its scale: less of others is not compared
    # 1e-4 of a coordinate's scale: a machine that moves less stays where it is
    slight = max(0.01 * float(largest.max(initial=0.0)), 1e-4)
    excess = np.abs(changes - dues) / (THREE_DIGITS * np.maximum(largest, slight))
    k, i = divmod(int(excess.argmax()), len(names))
    if not excess[k, i] <= 1.0:
        unit = f" {units[there[i]]}" if units[there[i]] else ""
        change, due = float(changes[k, i] * sizes[i]), float(dues[k, i] * sizes[i])
        other = ", the other way" if change * due < 0 and abs(due) > slight * sizes[i] else ""
        what = f"{trial.how} at {at}, within {k * SPAN / STEPS:.2g} s {names[i]} changes "
        yield WrongAnswerError(f"{what}by {change:.3g}{unit}{other}", f"{due:.3g}{unit}")


def _moved(task: PlanningTask, x: Array, u: Array) -> Array:
    """Return the states of a motion under inputs that are held, shape (STEPS + 1, nx)."""
    t = np.linspace(0.0, SPAN, STEPS + 1)
    return resimulate(replace(task, start=x), t, np.tile(u, (STEPS, 1))).x


def _inputs_for(asked: PlanningTask, given: PlanningTask, u: Array) -> Array:
    """Return inputs in the order of what was handed in: by name, or as they are listed."""
    names = asked.model.control_names
    if set(names) != set(given.model.control_names):
        return u
    return u[[names.index(name) for name in given.model.control_names]]


def state_for(
    asked: PlanningTask, given: PlanningTask, x: Array, names: Sequence[str]
) -> tuple[Array, tuple[str, float, str] | None]:
    """Return the state in which a machine is where another one is, and moves as that does.

    Args:
        asked: Provides that other machine.
        x: State of the other one, shape (nx,).
        names: Coordinates in which both agree; what else both name is taken over, but for rates.

    Returns:
        Shape (nx,); and a coordinate whose rate cannot be that of the other machine, with the rate
        that it has and the one that is due.
    """
    model, other = given.model, asked.model
    y, speeds = given.start.copy(), model.speeds
    own = {*model.state_names[: model.nq], *(model.state_names[k] for k in speeds)}
    for name in {*names, *(set(model.state_names) - own)} & set(other.state_names):
        y[model.state_names.index(name)] = x[other.state_names.index(name)]
    y[speeds] = 0.0
    here, there = ([one.model.state_names.index(name) for name in names] for one in (given, asked))
    wanted = other.f(x, other.null_control())[there]
    idle = model.f(y, model.null_control())[here]
    units = y + np.eye(model.nx)[speeds] * model.state_scales[speeds][:, None]
    effects = np.array([model.f(one, model.null_control())[here] - idle for one in units]).T
    if len(speeds):
        shares, *_ = np.linalg.lstsq(effects, wanted - idle, rcond=None)
        y[speeds] = shares * model.state_scales[speeds]
        idle = idle + effects @ shares
    sizes = np.maximum(np.abs(wanted), THREE_DIGITS * asked.scales[there])
    off = np.abs(idle - wanted) / sizes
    worst = int(off.argmax())
    if off[worst] <= THREE_DIGITS:
        return y, None
    return y, (names[worst], float(idle[worst]), f"{wanted[worst]:.4g}")
