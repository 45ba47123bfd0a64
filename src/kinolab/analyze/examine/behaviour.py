"""What a machine does, in sentences that its author can agree or disagree with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from kinolab.analyze.describe.conserved import conserved_momenta
from kinolab.analyze.describe.sizes import body_sizes
from kinolab.analyze.examine.odd_numbers import direction_of
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Axis, Body, Frame
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.frames import AXES, pose
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.dynamics.language.mechanism_parts import (
    atoms_of,
    coordinate_of,
    imposed_accelerations,
    loads_in,
)
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.model.units import in_digits
from kinolab.errors import KinolabError, counted, row_of
from kinolab.numerics.arrays import Array

LET_GO = 0.5  # [s]
STEPS = 500  # of that
SEEN = 1e-3  # [m] or [rad]: less is called rest
MOST = 3  # inputs, bodies and names that sentences name; more are counted


def behaviour(subject: Subject, start: Array | None = None) -> Iterator[str]:
    """Yield at most nine sentences about a machine.

    Args:
        start: The state (nx,) at which a scenario begins, to let it go there.
    """
    yield from _freedoms(subject)
    yield _gravity(subject)
    yield from _let_go(subject, start)
    yield from _inputs(subject)
    yield from _left_alone(subject)
    yield from _conserved(subject)
    yield from _sizes(subject)


def _freedoms(subject: Subject) -> Iterator[str]:
    model = subject.model
    try:
        _, rates = subject.in_motion(subject.rest)
        freedom = int(np.linalg.matrix_rank(rates, tol=1e-9 * max(1.0, np.abs(rates).max())))
    except KinolabError:
        freedom = model.nv
    follows = [name for k, name in enumerate(model.rate_names) if k not in model.independent]
    inputs = len(subject.system.inputs)
    told = f"It has {counted(len(subject.system.coordinates), 'coordinate')}"
    turning = len(subject.turning)
    told += f" ({counted(turning, 'rotation')} about every axis among them), " if turning else ", "
    told += f"{counted(freedom, 'degree')} of freedom and {counted(inputs, 'input')}"
    if model.velocity_names:
        told += (
            f"; {_listed(model.velocity_names)} {'are states' if model.nv > 1 else 'is a state'}"
        )
    if follows:
        told += f", {_listed(follows)} {'follow' if len(follows) > 1 else 'follows'} from "
        sources = ["them"] * is_kinematic(subject.system)
        told += " and ".join([*sources, *["the constraints"] * bool(subject.system.constraints)])
    yield f"{told}."


def _gravity(subject: Subject) -> str:
    gravity = subject.system.gravity
    if gravity is None:
        return "There is no gravity."
    way = direction_of(gravity)
    strength = subject.system.number(gravity.strength)
    standing = any(body.touches_ground for body in subject.system.bodies)
    against = {"-z": ", down onto the ground z = 0", "+z": ", up from the ground z = 0"}
    along = against.get(way, ", along the ground z = 0") if standing else ""
    return f"Gravity pulls toward {way}{along}, with {strength:.4g} m/s^2."


def _let_go(subject: Subject, start: Array | None) -> Iterator[str]:
    """Say how bodies move from rest with all inputs 0; from beside it if they stay there.

    Rest is where a scenario starts, or where all coordinates are 0 or as near to it as may be.
    """
    if is_kinematic(subject.system):
        yield "It is kinematic: its inputs are velocities, and without them it stays where it is."
        return
    # 0.1 of the span of coordinates: beside rest
    aside = subject.moved(dict.fromkeys(subject.plain, 0.1))
    places = [(subject.rest, _begun(subject, subject.rest)), (aside, _begun(subject, aside))]
    if start is not None:
        places.insert(0, (start, "Let go at the scenario's start"))
    for x, begin in places:
        try:
            moved = _moved(subject, x)
        except KinolabError:
            continue
        if moved:
            yield f"{begin}, in {LET_GO:g} s {_listed(moved, more='bodies')}."
            return
    yield f"Let go at rest or beside it, nothing moves in {LET_GO:g} s."


def _begun(subject: Subject, x: Array) -> str:
    """Say where a machine is let go."""
    begun = [f"{c} = {x[k]:.3g}" for c, k in subject.plain.items() if abs(x[k]) > SEEN]
    return f"Let go at {_listed(begun)}" if begun else "Let go at rest"


def _moved(subject: Subject, x: Array) -> list[str]:
    """Return what bodies do in clauses, those that move most first."""
    model = subject.model
    inputs = np.tile(model.null_control(), (STEPS, 1))
    end = model.steps(x, inputs, np.full(STEPS, LET_GO / STEPS))[-1]
    gravity = subject.system.gravity
    up = -np.array(gravity.down if gravity is not None else (0.0, 0.0, -1.0))
    clauses = []
    before, after = subject.poses(x), subject.poses(end)
    for k, body in enumerate(subject.system.bodies):
        way = after[k, :, 3] - before[k, :, 3]
        cosine = (np.trace(before[k, :, :3].T @ after[k, :, :3]) - 1) / 2
        turned, rise = float(np.arccos(np.clip(cosine, -1, 1))), float(way @ up)
        across = float(np.linalg.norm(way - rise * up))
        if max(abs(rise), across) > SEEN:
            if abs(rise) >= across:
                what = f"{body.name} {'rises' if rise > 0 else 'falls'} {abs(rise):.2g} m"
            else:
                what = f"{body.name} moves {across:.2g} m sideways"
                what += f" and {'rises' if rise > 0 else 'falls'} {abs(rise):.2g} m" * (
                    abs(rise) > SEEN)  # fmt: skip
            clauses.append((float(np.linalg.norm(way)), what))
        elif turned > SEEN:
            clauses.append((0.0, f"{body.name} turns by {turned:.2g} rad"))
    return [what for _, what in sorted(clauses, key=lambda clause: -clause[0])]


def _inputs(subject: Subject) -> Iterator[str]:
    """Say on what each input acts, about or along what, and against what it reacts."""
    inputs = subject.system.inputs
    for entry in inputs[:MOST]:
        lower, upper = bounds_of(entry)
        size = f"{lower:g} to {upper:g} {entry.unit}".rstrip()
        yield f"{entry.name} ({type(entry).__name__}, {size}): {_acts(subject, entry)}."
    if len(inputs) > MOST:
        more = ", ".join(entry.name for entry in inputs[MOST : 3 * MOST])
        more += ", …" * (len(inputs) > 3 * MOST)
        yield f"And {counted(len(inputs) - MOST, 'further input')}: {more}."


def _acts(subject: Subject, entry: Input) -> str:
    on, reacts = getattr(entry, "on", None), getattr(entry, "reacts_on", None)
    axis = getattr(entry, "about", None) or getattr(entry, "along", None)
    if isinstance(on, Body) and isinstance(axis, Axis):
        word = "about" if hasattr(entry, "about") else "along"
        against = "the world" if reacts is None else reacts.name
        return f"on {on.name}, {word} {_axis(subject, axis, on)}, reacts on {against}"
    if isinstance(getattr(entry, "between", None), tuple):
        ends = [_frame(subject, frame) for frame in entry.between]  # type: ignore[attr-defined]
        return f"pulls {ends[0]} and {ends[1]} together"
    if on is not None:
        return f"decides {'the acceleration of ' * (type(entry).__name__ == 'Drive')}{on}"
    users = [str(e) for e in subject.system.efforts if entry.symbol in set(atoms_of(e))]
    return f"in {_listed(users)}" if users else "in the equations of its states or requirements"


def _axis(subject: Subject, axis: Axis, on: Body) -> str:
    """Name an axis by the frame that it moves with."""
    if not axis.frame.moves:
        return _fixed(subject, axis)
    if axis.frame == on.frame:
        return f"its own {axis.name} axis"
    return f"the {axis.name} axis of {_frame(subject, axis.frame)}"


def _fixed(subject: Subject, axis: Axis) -> str:
    values = subject.system.substitutions
    turned = pose(axis.frame)[0].subs(values)[:, AXES[axis.name]]
    for k, name in enumerate("xyz"):
        if abs(abs(float(turned[k])) - 1) < 1e-9:
            return f"the world's {'-' * (float(turned[k]) < 0)}{name}"
    return "a fixed axis"


def _frame(subject: Subject, frame: Frame) -> str:
    """Name a frame by the body that has it, or by the coordinates that move it."""
    for body in subject.system.bodies:
        if body.frame == frame:
            return str(body.name)
    names = sorted(subject.moving(frame))
    return f"the frame that moves with {_listed(names)}" if names else "a point that is fixed"


def _left_alone(subject: Subject) -> Iterator[str]:
    """Name the coordinates along which no input, force, constraint or weight acts."""
    system = subject.system
    along = [c.velocity for c in system.constraints]
    along += [velocity for velocity, _ in subject.pushed_along]
    along += [written(load.velocity) for e in system.inputs for load in loads_in(e)]
    rates = {symbol for c in system.coordinates for symbol in c.rates}
    owners = (coordinate_of(atom) for part in along for atom in atoms_of(part) if atom in rates)
    held = {owner.name for owner in owners if owner is not None}
    held |= set(imposed_accelerations(system))
    free = [c.name for c in subject.plain if c.name not in held and not _weighs(subject, c.name)]
    if free:
        yield f"Nothing holds or drives {_listed(free)}: no input, force, constraint or weight."


def _weighs(subject: Subject, name: str) -> bool:
    """Whether the potential energy changes with a coordinate."""
    if is_kinematic(subject.system):
        return False
    k = subject.model.state_names.index(name)
    base = subject.moved(dict.fromkeys(subject.plain, 0.2))
    energies = []
    for share in (0.0, 0.1, 0.3):
        x = base.copy()
        x[k] += share * subject.model.state_scales[k]
        energies.append(subject.model.energy(x)[1])
    return bool(np.ptp(energies) > 1e-9 * max(map(abs, energies)))


def _conserved(subject: Subject) -> Iterator[str]:
    if is_kinematic(subject.system):
        return
    system, kept = subject.system, []
    idle = np.zeros(subject.model.nu)
    try:
        states = [subject.moved(dict.fromkeys(subject.plain, share)) for share in (0.1, -0.2)]
        for x in states:
            x[subject.model.speeds] = 0.3 * subject.model.state_scales[subject.model.speeds]
        powers = [abs(subject.model.power(x, idle)) for x in states]
        if not system.states and max(powers) <= 1e-9 * max(_energy_of(subject, x) for x in states):
            kept.append("its energy, while the inputs are 0")
        kept += [f"the momentum of {name}, whatever the inputs do"
                 for name in conserved_momenta(system)]  # fmt: skip
    except KinolabError:
        return
    yield f"What never changes: {_listed(kept)}." if kept else "Nothing is conserved."


def _energy_of(subject: Subject, x: Array) -> float:
    kinetic, potential = subject.model.energy(x)
    return max(1e-9, abs(float(kinetic)) + abs(float(potential)))


def _sizes(subject: Subject) -> Iterator[str]:
    """Compare the lightest with the heaviest, and the smallest with the largest."""
    bodies = body_sizes(subject.system)
    heavy = sorted((b for b in bodies if b.mass > 0), key=lambda b: b.mass)
    solid = sorted((b for b in bodies if b.extent), key=lambda b: max(b.extent or (0,)))
    told = []
    if heavy:
        one, other = heavy[0], heavy[-1]
        what = "its masses are" if heavy[1:] else "its mass is"
        told.append(f"{what} {_span(one.mass, one.name, other.mass, other.name, 'kg')}")
    if solid:
        sizes = [(max(b.extent or (0.0,)), b.name) for b in (solid[0], solid[-1])]
        what = "its sizes are" if solid[1:] else "its size is"
        told.append(f"{what} {_span(*sizes[0], *sizes[1], 'm')}")
    if told:
        text = ", ".join(told)
        yield f"{text[0].upper()}{text[1:]}."


def _span(low: float, first: str, high: float, last: str, unit: str) -> str:
    if first == last:
        return f"{in_digits(high)} {unit} ({last})"
    return f"{in_digits(low)} {unit} ({first}) to {in_digits(high)} {unit} ({last})"


def _listed(names: Iterable[object], more: str = "others") -> str:
    """Join names: ``a, b and c``; those beyond ``2 MOST`` are counted."""
    words: Sequence[object] = list(names)
    if len(words) > 2 * MOST:
        words = [*words[: 2 * MOST - 1], f"{len(words) - 2 * MOST + 1} {more}"]
    return row_of(words)
