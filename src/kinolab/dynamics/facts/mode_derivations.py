"""Machines with modes: one derivation for each, guards of the transitions, and what they reset.

All derivations have the same state: coordinates, every rate, auxiliary states and the mode. What a
mode does not have, such as a constraint of another one, is zero in it.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6;
Brogliato, Nonsmooth Mechanics, 3rd ed., 2016, section 4.2 (kinetic metric of an impact).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from kinolab.arguments import checked
from kinolab.dynamics.derivation.derivation import Derivation, derive, is_kinematic
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_definite
from kinolab.dynamics.derivation.velocity_coordinates import (
    combine,
    constraint_rows,
    independent_rows,
)
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.frames import time_derivative
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import atoms_of, imposed_velocities
from kinolab.dynamics.language.modes import MODE, Mode, Transition
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import ForceSymbol
from kinolab.errors import InputError, Mistake, UnknownNameError


@dataclass(frozen=True)
class ModeDerivation:
    """Equations of one mode.

    Attributes:
        derivation: Of the machine while it is in this mode, with the symbols of all modes.
        targets: Index of the mode that each of its transitions leads to.
        switches: By the names of functions of a state: ``guards``, of each transition what it lasts
            until, the rate of that, and what else must be positive; ``reset0``, …, of each the
            state after impact and reset, constraints of the target apart; ``landed``, the state
            with velocities that the mode's own constraints forbid stopped.
    """

    derivation: Derivation
    targets: tuple[int, ...]
    switches: dict[str, tuple[Node, ...]]


@checked
def in_mode(system: Mechanism, mode: str) -> Mechanism:
    """Return a machine as it is in one of its modes: one without modes, to be looked at by itself.

    It has the inputs that have an effect in this mode.

    Args:
        system: The machine.
        mode: The mode's name.

    Raises:
        InputError: If it has no such mode.
    """
    names = [entry.name for entry in system.modes]
    if mode not in names:
        raise UnknownNameError("mode", mode, known=names)
    states = [entry for entry in system.states if entry.name != MODE]
    made = machine_in_mode(system, names.index(mode)).changed(
        states=states, velocities=system.velocities
    )
    d = derive(made, idle_inputs=True)
    acting = [e for e, node in zip(made.inputs, d.binding.inputs, strict=True) if _reaches(d, node)]
    return made.changed(inputs=acting)


def machine_in_mode(system: Mechanism, index: int) -> Mechanism:
    """Return a machine as it is in one of its modes, with the same symbols in the same order."""
    mode = system.modes[index]
    constrained = any(m.constraints for m in system.modes) or bool(system.constraints)
    everything = "all" if constrained and not is_kinematic(system) else system.velocities
    made = system.changed(
        constraints=(*system.constraints, *mode.constraints),
        efforts=(*system.efforts, *mode.efforts),
        requirements=(*system.requirements, *mode.requirements),
        velocities=everything,
        modes=(),
        transitions=(),
    )
    object.__setattr__(made, "parameters", system.parameters)  # in one order for all modes
    return made


def _speeds_beside_masses(system: Mechanism) -> Iterator[Mistake]:
    """Yield the speeds that are given where bodies have masses and modes bind them differently.

    Forces of constraints come from all rates as unknowns then, of which none may be given.
    """
    constrained = system.constraints or any(mode.constraints for mode in system.modes)
    if not constrained or is_kinematic(system):
        return
    for entry in imposed_velocities(system):
        what = "it sets a speed, which a machine with masses, modes and constraints cannot have."
        remedy = "Let it set an acceleration (Drive), or push (Force, Torque) against a damper."
        yield Mistake(f"system {system.name!r} {entry.where}", what, remedy)


def derive_modes(system: Mechanism) -> list[ModeDerivation]:
    """Derive the equations of motion of every mode.

    Raises:
        InputError: As ``derive``, in any of the modes; if the modes have different independent
            velocities; if an input reaches nothing in all of them.
    """
    if system.feedback is not None:
        what = "a machine with modes has no feedback of its own yet."
        raise InputError([Mistake(f"system {system.name!r} feedback", what, "Leave it out.")])
    mistakes = [*_speeds_beside_masses(system)]
    if mistakes:
        raise InputError(mistakes)
    machines = [machine_in_mode(system, index) for index in range(len(system.modes))]
    derived: list[Derivation] = []
    for mode, machine in zip(system.modes, machines, strict=True):
        try:
            derived.append(derive(machine, idle_inputs=True))
        except InputError as error:
            where = f"mode {mode.name!r}"
            mistakes += [Mistake(f"{where} {m.where}", m.what, m.remedy) for m in error.mistakes]
    if mistakes:
        raise InputError(mistakes)
    _require_alike(system, derived)
    projects = any(d.projection for d in derived)
    return [
        _mode(system, mode, _widened(system, d, projects=projects))
        for mode, d in zip(system.modes, derived, strict=True)
    ]


def _require_alike(system: Mechanism, derived: Sequence[Derivation]) -> None:
    where = f"system {system.name!r}"
    if len({(d.independent, len(d.state), len(d.quasi)) for d in derived}) > 1:
        what = "its modes have different independent velocities."
        raise InputError([Mistake(where, what, "Leave velocities= out.")])
    if derived[0].quasi:
        what = "a machine with modes has rates as velocities, no quasi-velocities."
        raise InputError([Mistake(where, what, "Leave velocities= out.")])
    asked = set(
        atoms_of((system.transitions, system.requirements))
    )  # such as a hand's command to close
    for i, entry in enumerate(system.inputs):
        reached = any(_reaches(d, d.binding.inputs[i]) for d in derived)
        if not (reached or entry.symbol in asked):
            what = "it reaches nothing in any mode, and no transition asks it."
            raise InputError([Mistake(f"input {entry.name!r}", what, "Leave it out.")])


def _reaches(d: Derivation, node: Node) -> bool:
    tape = d.binding.tape
    return any(node in tape.depends_on(result) for result in d.derivative)


def _widened(system: Mechanism, d: Derivation, *, projects: bool) -> Derivation:
    """Return a mode's derivation with an entry for what only other modes have.

    Args:
        own: The machine in this mode.
        d: Its derivation.
        projects: Whether any mode moves states back onto constraints.
    """
    tape = d.binding.tape
    own, everything = d.binding.system, system.all_constraints
    names = [c.name for c in own.constraints]
    closing = [closure.name for closure in own.closures]
    speeds = dict(zip(names, d.constraint_residual, strict=False))
    gaps = dict(zip(closing, d.constraint_residual[len(names) :], strict=True))
    acting = [name for name in names if name not in d.redundant]
    forces = dict(zip(names if len(d.constraint_forces) == len(names) else acting,
                      d.constraint_forces, strict=False))  # fmt: skip
    margins = dict(zip((r.name for r in own.requirements), d.requirements, strict=True))
    massive = bool(d.energy) and bool(everything)
    return replace(
        d,
        constraint_residual=(
            *(speeds.get(c.name, tape.zero) for c in everything),
            *(gaps.get(c.name, tape.zero) for c in everything if isinstance(c, PositionConstraint)),
        ),
        constraint_forces=tuple(forces.get(c.name, tape.zero) for c in everything)
        if massive
        else (),
        requirements=tuple(margins.get(r.name, tape.one) for r in system.all_requirements),
        projection=d.projection or (d.state if projects else ()),
    )


def _mode(system: Mechanism, own: Mode, d: Derivation) -> ModeDerivation:
    names = [mode.name for mode in system.modes]
    leaving = [t for t in system.transitions if t.source == own.name]
    targets = tuple(names.index(t.target) for t in leaving)
    lower = _lowering(system, d)
    switches = {"guards": tuple(node for t in leaving for node in _guard(d, lower, t))}
    for k, (transition, target) in enumerate(zip(leaving, targets, strict=True)):
        switches[f"reset{k}"] = _reset(d, lower, transition, target)
    return ModeDerivation(d, targets, switches | {"landed": _landed(d)})


def _lowering(system: Mechanism, d: Derivation) -> Callable[[object], Node]:
    """Return what turns expressions into nodes of states and inputs, forces included."""
    tape = d.binding.tape
    names = (c.name for c in system.all_constraints)
    forces = {
        ForceSymbol(name): node for name, node in zip(names, d.constraint_forces, strict=False)
    }
    lower = Lowering(tape, d.binding.lower.symbols | forces)
    at = d.binding.at(d.velocities)
    return lambda expression: tape.substitute([lower(expression)], at)[0]


def _guard(
    d: Derivation, lower: Callable[[object], Node], transition: Transition
) -> tuple[Node, Node, Node]:
    tape = d.binding.tape
    until = lower(transition.until)
    (rate,) = tape.derivative([until], dict(zip(d.state, d.derivative, strict=True)))
    if not tape.depends_on(until) & set(d.state):
        rate = tape.constant(
            -1.0
        )  # inputs decide, and jump: where it is not positive, it has fallen
    condition = transition.provided
    return until, rate, tape.one if condition is None else lower(condition)


def _reset(
    d: Derivation, lower: Callable[[object], Node], transition: Transition, target: int
) -> tuple[Node, ...]:
    """Return the state after the impact along ``until`` and the reset."""
    tape = d.binding.tape
    after = list(d.state)
    if transition.restitution is not None:
        if not d.energy:
            what = f"{d.binding.system.name} is kinematic: nothing in it can bounce."
            where = f"transition {transition.name!r}"
            raise InputError([Mistake(where, what, "Leave restitution out.")])
        _, slopes = d.binding.slopes(time_derivative(exact(transition.until)))
        struck = _struck(d, [slopes], lower(transition.restitution))
        first = len(d.binding.configuration)
        after[first : first + len(struck)] = struck
    known = dict(zip(d.state, after, strict=True))
    for symbol, expression in dict(transition.reset).items():
        (value,) = tape.substitute([lower(expression)], known)
        after[d.state.index(tape.variable(symbol.name))] = value
    after[-1] = tape.constant(float(target))
    return tuple(after)


def _landed(d: Derivation) -> tuple[Node, ...]:
    """Return the state after a perfectly inelastic impact onto the constraints of a mode."""
    if not d.energy or not d.binding.system.constraints:
        return d.state
    rows = independent_rows(d.binding, constraint_rows(d.binding))[0]
    struck = _struck(d, [row.covector for row in rows], d.binding.tape.zero)
    first = len(d.binding.configuration)
    return (*d.state[:first], *struck, *d.state[first + len(struck) :])


def _struck(d: Derivation, covectors: Sequence[Sequence[Node]], restitution: Node) -> list[Node]:
    """Return v - (1 + e) M^-1 J^T (J M^-1 J^T)^-1 J v, for rows J and a coefficient e."""
    tape, size = d.binding.tape, len(d.velocities)
    M = [list(d.mass_matrix[i * size : (i + 1) * size]) for i in range(size)]
    compliant = solve_definite(tape, M, covectors, Guards())
    G = [[tape.dot(row, column) for column in compliant] for row in covectors]
    factor = tape.add(tape.one, restitution)
    speeds = [tape.mul(factor, tape.dot(row, d.velocities)) for row in covectors]
    (blows,) = solve_definite(tape, G, [speeds], Guards())
    change = combine(d.binding, compliant, blows)
    return [tape.sub(v, c) for v, c in zip(d.velocities, change, strict=True)]
