"""Friction and other forces that feed energy into a machine whose inputs are zero."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from kinolab.analyze.examine.forces_twice import generalised, is_between_frames
from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import UNLIMITED, Subject
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.constraints import Requirement
from kinolab.dynamics.language.forces import Effort, Load
from kinolab.dynamics.language.mechanism_parts import (
    atoms_of,
    configuration_symbols,
    coordinate_of,
    energies_in,
    loads_in,
    tangent_symbols,
)
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import (
    InputSymbol,
    Parameter,
    RateSymbol,
    ReferenceSymbol,
    StateSymbol,
)
from kinolab.simulation.stability import random_states

STEP = 1e-5  # of coordinates: the error of central differences is its square


def energy_sources(subject: Subject) -> Iterator[Remark]:
    """Yield the forces whose work is positive though the machine's inputs are zero.

    Friction must not do any. A wrench may, such as a wind's; but if it does so however the motion
    is reversed, it is friction with the wrong sign.
    """
    system, model = subject.system, subject.model
    for effort in system.efforts:
        stiffness = getattr(effort, "stiffness", 0)
        if _known(stiffness) and system.number(stiffness) < 0:
            what = (
                f"Its stiffness is {system.number(stiffness):g} N/m: it pushes its ends apart the "
            )
            what += "more the longer it is. A spring that pulls back has a positive one."
            yield Remark("spring that pushes", "", what, (type(effort).__name__, ""))
    yield from _repelling(subject)
    yield from _one_sided(subject)
    yield from _self_feeding(subject)
    yield from _other_motion(subject)
    yield from _circulating(subject)
    suspects = [effort for effort in system.efforts if _may_feed(effort)]
    if not suspects or is_kinematic(system):
        return
    margins = tuple(Requirement(effort.power, f"power {k}") for k, effort in enumerate(suspects))
    watched = system.changed(requirements=margins, flat=None, expected=()).model()
    states = random_states(model)
    reversed_ = states.copy()
    reversed_[:, model.speeds] *= -1.0
    idle = model.null_control()
    there, back = (watched.requirements(x, idle) for x in (states, reversed_))
    ends = np.clip(model.control_bounds, -UNLIMITED, UNLIMITED).T
    both = np.min([watched.requirements(states, u) + watched.requirements(reversed_, u)
                   for u in (idle, *ends)], axis=0)  # fmt: skip
    for k, effort in enumerate(suspects):
        if both[:, k].max() > 0:  # else an input may undo it
            yield from _found(effort, there[:, k], back[:, k])


def _repelling(subject: Subject) -> Iterator[Remark]:
    """Yield the springs that are written as energies or forces, and push away from their rest."""
    system = subject.system
    values = system.substitutions
    for effort in system.efforts:
        if any(str(getattr(a, "unit", "")) == "m/s^2" for a in atoms_of(effort)):
            continue  # a weight, which may well have a maximum
        energies = [exact(energy) for energy in energies_in(effort)]
        if any(_has_maximum(energy.subs(values)) for energy in energies) or (
            not energies and any(_pushes(load, values) for load in loads_in(effort))
        ):
            what = f"The {effort} pushes away from where it is at rest, the more the farther: its "
            what += "energy has a maximum there. That of a spring has a minimum, + k * s**2 / 2, "
            what += "and its force is against s, - k * s: is the sign wrong?"
            moved = ", ".join(sorted({c.name for c in subject.plain} & set(_owners(effort))))
            yield Remark("spring that pushes", moved, what, (type(effort).__name__, ""))


def _one_sided(subject: Subject) -> Iterator[Remark]:
    """Yield the drag that pushes one way only: no force at rest, and the same at -v as at v.

    It depends on the velocity that it is along alone; a lift depends on another one.
    """
    values = subject.system.substitutions
    for effort in subject.system.efforts:
        driven = StateSymbol | ReferenceSymbol | InputSymbol
        if is_between_frames(effort) or any(isinstance(a, driven) for a in atoms_of(effort)):
            continue
        for load in loads_in(effort):
            along, size = (exact(written(e)).subs(values) for e in (load.velocity, load.magnitude))
            rates = sorted((a for a in along.free_symbols if isinstance(a, RateSymbol)), key=str)
            if not rates or not size.has(*rates):
                continue
            speed = sympy.Symbol("v", real=True)
            alone = size.subs(rates[0], sympy.solve(along - speed, rates[0])[0])
            alone = sympy.simplify(alone)
            if (
                alone.free_symbols == {speed}
                and not alone.subs(speed, 0)
                and sympy.simplify(alone - alone.subs(speed, -speed)) == 0
            ):
                what = (
                    f"The {effort} is the same forward and backward: against the motion one way, "
                )
                what += "and along with it the other way. Drag is against it both ways: "
                what += "-c * v * abs(v)."
                yield Remark("friction that pushes", str(effort), what, (type(effort).__name__, ""))
                break


def _self_feeding(subject: Subject) -> Iterator[Remark]:
    """Yield the auxiliary states that push a motion on by which they grow themselves.

    Of a motor, force = k i and voltage = k v are of one k and of opposite senses.
    """
    model = subject.model
    pushes = {a for e in subject.system.efforts for a in atoms_of(e) if isinstance(a, StateSymbol)}
    for entry in subject.system.states:
        if entry.symbol not in pushes:
            continue
        k = model.state_names.index(entry.name)
        slopes = [model.jacobian(x, model.null_control())[0] for x in random_states(model)]
        fed = [float((A[model.speeds, k] * A[k, model.speeds]).sum()) for A in slopes]
        if min(fed) > 0:
            what = f"{entry.name} pushes the machine, and grows the more the faster that makes it: "
            what += "without any input both grow. The voltage of a motor that turns is against its "
            what += "current, as in (u - R * i - k * rate(phi)) / L."
            yield Remark("state that feeds itself", entry.name, what, ("State", entry.name))
        elif min(A[k, k] for A in slopes) > 0:
            what = f"{entry.name} grows the faster the larger it is, by itself: it runs away. What "
            what += "follows a signal has a derivative of (signal - state) / time, time above 0."
            yield Remark("state that grows by itself", entry.name, what, ("State", entry.name))


def _other_motion(subject: Subject) -> Iterator[Remark]:
    """Yield the auxiliary states that feel another motion than they push, by the same constant.

    A coil with force = k i has voltage = k v of the same v, or it would make energy.

    Source: Crandall, Karnopp, Kurtz, Pridmore-Brown, Dynamics of Mechanical and Electromechanical
    Systems, 1968, chapter 6.
    """
    system, model = subject.system, subject.model
    rates = tangent_symbols(system)
    symbols = [*configuration_symbols(system), *rates]
    values = system.substitutions
    loads = [load for effort in system.efforts for load in loads_in(effort)]
    for entry in system.states:
        mine = [(exact(load.magnitude).diff(entry.symbol), load) for load in loads]
        power = sum((size * written(load.velocity) for size, load in mine if size), sympy.S.Zero)
        voltage = sum((exact(entry.derivative).diff(r) * r for r in rates), sympy.S.Zero)
        shared = {s for size, _ in mine for s in size.free_symbols} & voltage.free_symbols
        pair = [power.subs(values), voltage.subs(values)]
        if not shared & set(values) or {*pair[0].free_symbols, *pair[1].free_symbols} - {*symbols}:
            continue
        states, idle = random_states(model), model.null_control()
        moving = model.velocity(states, np.tile(idle, (len(states), 1)))
        powers = sympy.lambdify(symbols, pair, "numpy")
        one, other = np.array(
            [powers(*x[: model.nq], *v) for x, v in zip(states, moving, strict=True)]
        ).T
        cosine = abs(one @ other) / max(float(np.linalg.norm(one) * np.linalg.norm(other)), 1e-300)
        # 1e-6: one minus the cosine between two powers, over many states: rounding, and no more
        if cosine < 1 - 1e-6:
            felt = " and ".join(sorted(str(s) for s in voltage.free_symbols & set(rates)))
            pushed = " and ".join(sorted(str(s) for s in power.free_symbols & set(rates)))
            what = f"{entry.name} pushes along {pushed}, and feels {felt}, by the same "
            what += f"{' and '.join(sorted(map(str, shared & set(values))))}: such a motor makes "
            what += "energy. What a coil feels is the speed of the body that it turns."
            yield Remark("state that feels another motion", entry.name, what, ("State", entry.name))


def _circulating(subject: Subject) -> Iterator[Remark]:
    """Yield that forces of positions do work in a cycle, since they belong to no energy.

    Then the slopes of the forces along coordinates are not symmetric.

    Source: Ziegler, Principles of Structural Stability, 1968, section 1.4 (circulatory forces).
    """
    system, model = subject.system, subject.model
    efforts = [e for e in system.efforts if any(loads_in(e)) and not is_between_frames(e)]
    efforts = [e for e in efforts if not e.size and all(_placed(v.magnitude) for v in loads_in(e))]
    states, columns = random_states(model), [*subject.plain.values()]
    if not efforts or system.constraints or is_kinematic(system):
        return
    still = np.zeros((len(states), model.nq))
    changes = np.array([
        np.sum([way * generalised(subject, effort, states + way * step, still)
                for effort in efforts for way in (1, -1)], axis=0)
        for step in STEP * np.eye(model.nx)[columns]
    ])  # fmt: skip
    gap = np.abs(changes - np.swapaxes(changes, 0, 2)).max(axis=1)
    if gap.max() > STEP * np.abs(changes).max():
        names = [c.name for c in subject.plain]
        one, other = (names[k] for k in np.unravel_index(np.argmax(gap), gap.shape))
        what = f"Round a cycle of {one} and {other} these forces do work: {one} does not push "
        what += f"{other} as {other} pushes {one}. What a spring does to one body it does to the "
        what += "other, the other way round: is a reaction missing, or the name of a coordinate "
        what += "another one's?"
        part = (type(efforts[0]).__name__, "")
        yield Remark("forces that make energy", f"{one} and {other}", what, part)


def _placed(size: Any) -> bool:
    """Whether a force depends on coordinates, and on nothing else that changes."""
    moving = RateSymbol | StateSymbol | ReferenceSymbol | InputSymbol
    own = exact(written(size)).free_symbols
    return not any(isinstance(a, moving) for a in own) and any(coordinate_of(a) for a in own)


def _owners(effort: Effort) -> Iterator[str]:
    owners = (coordinate_of(atom) for atom in atoms_of(effort))
    yield from (owner.name for owner in owners if owner is not None)


def _has_maximum(energy: sympy.Expr) -> bool:
    """Whether the even powers in an energy are negative, so that it has no lower bound."""
    squares = [
        term
        for term in sympy.Add.make_args(energy)
        if any(isinstance(f, sympy.Pow) and f.exp.is_even and f.exp.is_positive
               and f.base.free_symbols for f in term.args)
    ]  # fmt: skip
    signs = [term.as_independent(*term.free_symbols, as_Add=False)[0] for term in squares]
    return bool(signs) and all(sign.is_negative for sign in signs)


def _pushes(load: Load, values: dict[Parameter, float]) -> bool:
    """Whether a force grows in proportion to a coordinate, along that coordinate's rate."""
    along, size = written(load.velocity), exact(load.magnitude).subs(values)
    rates = [a for a in along.free_symbols if isinstance(a, RateSymbol)]
    coordinate = coordinate_of(rates[0]) if len(rates) == 1 else None
    if coordinate is None or coordinate not in size.free_symbols:
        return False
    slope = (size.diff(coordinate) * along.diff(rates[0])).subs(values)
    return bool(slope.is_number and slope.is_positive)


def _found(
    effort: Effort, there: NDArray[np.float64], back: NDArray[np.float64]
) -> Iterator[Remark]:
    """Judge the powers of a force in [W] at states and at the reversed ones, shape (m,) each."""
    largest = max(np.abs(there).max(), np.abs(back).max())
    if not (np.isfinite(largest) and largest > 0):
        return
    # 1e-9 of the largest power of a force: a smaller one counts as zero
    if float(np.minimum(there, back).max() / largest) > 1e-9:
        most = float(np.maximum(there, back).max())
        what = (
            f"The {effort} feeds in up to {most:.3g} W while all inputs are 0, whichever way the "
        )
        what += "machine moves: friction has the sign of -velocity."
        yield Remark("friction that pushes", str(effort), what, (type(effort).__name__, ""))


def _known(value: Any) -> bool:
    return all(isinstance(symbol, Parameter) for symbol in exact(value).free_symbols)


def _may_feed(effort: Effort) -> bool:
    """Say whether a force might feed energy in though inputs are zero."""
    driven = StateSymbol | ReferenceSymbol
    if not any(loads_in(effort)) or any(isinstance(a, driven) for a in atoms_of(effort)):
        return False  # it may be driven
    if not effort.size:
        return True
    return not _known(getattr(effort, effort.size))  # numbers and parameters were validated
