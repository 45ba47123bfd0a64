"""Whether a machine can rest: where something holds it within all limits, and what is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from operator import itemgetter
from typing import TypeAlias

import numpy as np
from scipy.optimize import lsq_linear

from kinolab.analyze.examine.odd_numbers import direction_of
from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import UNLIMITED, Subject
from kinolab.dynamics import Model, toward
from kinolab.dynamics.analysis.fields.linear_controllability import linear_controllability
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.constraints import VelocityConstraint
from kinolab.dynamics.language.mechanism_parts import atoms_of, loads_in
from kinolab.dynamics.model.units import control_units, state_units
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.dynamics.symbols.symbols import RateSymbol
from kinolab.errors import KinolabError, row_of
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states

Mass: TypeAlias = Callable[[Model, Array], Array]

STEP = 1e-6  # of a coordinate, of differences of the mass matrix
ROUNDING = 1e-12  # [kg] or [kg m^2]
HELD = 1e-6  # of a state's scale per second: slower counts as held
DOWN = (0.0, 0.0, -1.0)


def without_rest(subject: Subject) -> Iterator[Remark]:
    """Yield that nothing holds a machine within its limits, though something would beyond them.

    What nothing holds beyond them either may be meant to fall, as what is thrown, and is silent.

    Source: Bertsekas, Nonlinear Programming, 3rd ed., 2016, section 3.3 (Gauss, Newton in a box).
    """
    model = subject.model
    if is_kinematic(subject.system):
        return
    box = np.vstack([model.state_bounds, model.control_bounds])
    found = []
    for start in (subject.rest, *random_states(model)):
        z, left = _settled(subject, np.append(start, model.null_control()), box)
        if left <= 1e-3:  # of the same, within limits: the search for it may end before it is held
            return
        found += [(left, z)] if np.isfinite(left) else []
    free = np.full_like(box, np.inf) * (-1, 1)
    places, inputs = free.copy(), free.copy()
    places[model.nx :], inputs[: model.nx] = box[model.nx :], box[: model.nx]
    for growth, wider in product((1.0, 2.0), (places, inputs, free)):
        for _, z in sorted(found, key=lambda entry: entry[0]):
            held, left = _settled(subject, z, wider, growth)
            beyond = np.abs(held) / np.maximum(np.abs(box).max(axis=1), ROUNDING)
            # An input beyond 100 times its limit has one in another unit, a factor of 1000
            if left <= HELD and (growth == 1.0 or beyond[model.nx :].max(initial=0.0) >= 100.0):
                yield _restless(subject, found, held, box)
                return


def _in_another_unit(subject: Subject, z: Array, box: Array) -> str:
    """Say which masses and stiffnesses, a thousand times as large or small, let it rest near z."""
    system, right = subject.system, []
    for p in (p for p in system.parameters if p.unit in {"kg", "N/m", "N m", "N m/rad"}):
        for value in (system.parameter_values[p.name] * factor for factor in (1e3, 1e-3)):
            other = Subject(system.with_parameters(**{p.name: value}))
            right += [f"{p.name} = {value:.4g} {p.unit}"] * (_settled(other, z, box)[1] <= HELD)
    return f" It would rest with {' or '.join(right)}, too." if right else ""


def _settled(subject: Subject, z: Array, box: Array, growth: float = 1.0) -> tuple[Array, float]:
    """Return the state and inputs (nx + nu,) near others that are held best, and what is left.

    Accelerations are reduced, and where that ends too early, the forces that nothing balances:
    accelerations alone are least, too, where the inertia is largest.

    Args:
        z: States and inputs, shape (nx + nu,); velocities are set to 0.
        box: Their limits, shape (nx + nu, 2).
        growth: Of the steps, after one that led nearer; 1 keeps them within half a range each.
    """
    best = _descended(subject, z, box, _alike, growth)
    return (
        best
        if best[1] <= HELD
        else min(best, _descended(subject, z, box, _mass, growth), key=itemgetter(1))
    )


def _descended(
    subject: Subject, z: Array, box: Array, mass: Mass, growth: float
) -> tuple[Array, float]:
    """Do what ``_settled`` does, with accelerations weighted by a mass matrix."""
    model, scales = subject.model, subject.model.state_scales
    moves = np.ones(len(z), dtype=bool)
    moves[model.speeds] = False
    halves = np.minimum(np.diff(model.control_bounds)[:, 0] / 2, UNLIMITED)
    sizes = np.append(scales, np.where(halves > 0, halves, 1.0))[moves]
    z = np.where(moves, np.clip(z, *box.T), 0.0)
    radius = 1.0
    try:
        units = scales.copy()
        units[model.speeds] *= np.maximum(np.diag(mass(model, z[: model.nq])), ROUNDING)
        left = _unbalanced(model, z, mass) / units
        for _ in range(40):  # of Newton's method within limits
            # 1e-3 in scales of coordinates and halves of inputs' ranges: of a step
            if np.abs(left).max(initial=0.0) <= HELD**2 or radius < 1e-3:
                break
            rows = _slopes(model, z, mass)[:, moves]
            room = (box - z[:, None])[moves] / sizes[:, None]
            ends = np.clip(room, -radius, radius) + np.array([-1e-12, 1e-12])  # it may be at one
            step = lsq_linear(rows * sizes / units[:, None], -left, ends.T).x * sizes
            for k in range(6):  # of a step that leads away
                tried = z.copy()
                tried[moves] += step / 2**k
                tried[: model.nx] = model.project(tried[: model.nx])
                tried = np.clip(tried, *box.T)
                then = _unbalanced(model, tried, mass) / units
                if np.linalg.norm(then) < np.linalg.norm(left) * (1 - 1e-4 / 2**k):
                    z, left, radius = tried, then, radius / 2 if k else growth * radius
                    break
            else:
                radius /= 8
    except (KinolabError, ValueError, np.linalg.LinAlgError):
        return z, np.inf
    moving = model.f(z[: model.nx], z[model.nx :]) / scales
    return z, float(np.abs(moving).max(initial=0.0))


def _unbalanced(model: Model, z: Array, mass: Mass) -> Array:
    """Return the rates of a state at rest, shape (nx,), those of speeds weighted."""
    rates = np.array(model.f(z[: model.nx], z[model.nx :]), dtype=float)
    rates[model.speeds] = mass(model, z[: model.nq]) @ rates[model.speeds]
    return rates


def _slopes(model: Model, z: Array, mass: Mass) -> Array:
    """Return the derivatives of ``_unbalanced``, shape (nx, nx + nu)."""
    q, speeds = z[: model.nq], model.speeds
    rows = np.hstack(model.jacobian(z[: model.nx], z[model.nx :]))
    here, moved = mass(model, q), model.f(z[: model.nx], z[model.nx :])[speeds]
    rows[speeds] = here @ rows[speeds]
    for k in range(model.nq):
        beside = q.copy()
        beside[k] += STEP
        rows[speeds, k] += (mass(model, beside) - here) @ moved / STEP
    return rows


def _alike(model: Model, _q: Array) -> Array:
    return np.eye(model.nv)


def _mass(model: Model, q: Array) -> Array:
    """Return the mass matrix of the speeds, (nv, nv); none where some follow from others."""
    mass = model.mass_matrix(q)
    return mass if len(mass) == model.nv else np.eye(model.nv)


def _restless(
    subject: Subject, found: list[tuple[float, Array]], held: Array, box: Array
) -> Remark:
    """Say what moves off where it is held best, and beyond which limits it would rest."""
    system, model = subject.system, subject.model
    names = (*model.state_names, *model.control_names)
    units = dict(zip(names, (*state_units(model), *control_units(model)), strict=True))
    slack = HELD * np.maximum(1.0, np.abs(held))
    outside = np.flatnonzero((held < box[:, 0] - slack) | (held > box[:, 1] + slack))
    beyond = [
        f"{names[k]} = {held[k]:.3g} {units[names[k]]}".rstrip()
        + f" (limits {box[k, 0]:g} and {box[k, 1]:g})"
        for k in outside
    ]
    _, z = min(found, key=lambda entry: entry[0])
    moving = _moving_off(subject, z[: model.nx], z[model.nx :])
    gravity = system.gravity
    pull = f" against gravity toward {direction_of(gravity)}" if gravity else ""
    what = f"Within the limits of its coordinates and inputs nothing holds it{pull}: at best, "
    what += f"{row_of(moving[:3])}. It would rest with {row_of(beyond[:3])}. "
    if gravity is not None and gravity.down != DOWN and _rests_below(subject):
        what += 'With gravity toward "-z" it would rest within them.'
    elif short := [e for e in system.efforts if is_zero(getattr(e, "length", 1))]:
        what += f"The {short[0]} has no length= of its own, and pulls its ends together until they "
        what += "meet."
    else:
        what += "Are a mass, a stiffness or a limit in another unit, has a force or a constraint "
        what += f"the wrong sign or place?{_in_another_unit(subject, z, box)}"
    about = names[outside[0]] if len(outside) else ""
    return Remark("cannot rest", about, what, _part_of(subject, about))


def _rests_below(subject: Subject) -> bool:
    """Whether a machine would rest somewhere if gravity pulled toward -z."""
    system, gravity = subject.system, subject.system.gravity
    strength = 0.0 if gravity is None else gravity.strength
    return not any(without_rest(Subject(system.changed(gravity=toward("-z", strength), flat=None))))


def _part_of(subject: Subject, name: str) -> tuple[str, str]:
    """Return the word of the language that made an input or a coordinate, and its name."""
    for entry in subject.system.inputs:
        if entry.name == name:
            return type(entry).__name__, name
    units = {c.name: c.unit for c in subject.plain}
    return ("angle" if units.get(name) == "rad" else "length", name)


def _moving_off(subject: Subject, x: Array, u: Array) -> list[str]:
    """Say how bodies begin to move from rest, those that do so fastest first."""
    rates, gravity = subject.begun(x, u), subject.system.gravity
    up = -np.array(gravity.down if gravity is not None else (0.0, 0.0, -1.0), dtype=float)
    slopes, told = subject.poses_by(x), []
    for k, body in enumerate(subject.system.bodies):
        way = slopes[k, :, 3] @ rates
        turn = float(np.linalg.norm(subject.spin(body, x) @ rates))
        rise, fast = float(way @ up), float(np.linalg.norm(way))
        verb = ("rises" if rise > 0 else "falls") if abs(rise) > fast / 2 else "moves aside"
        told.append((fast, f"{body.name} {verb} with {fast:.2g} m/s^2"))
        told.append((turn * 1e-3, f"{body.name} turns with {turn:.2g} rad/s^2"))
    told.sort(key=lambda entry: -entry[0])
    # 0.02 of the largest acceleration: smaller ones are not told
    return [what for size, what in told if size > 0.02 * told[0][0]]


def overturned(subject: Subject) -> Iterator[Remark]:
    """Yield that what floats or stands at rest turns over, by a motion that no input acts on.

    What rolls may keep upright by moving on, and is silent.

    Source: Hautus, Controllability and observability conditions, Indag. Math. 31, 1969.
    """
    system, model = subject.system, subject.model
    rolling = any(isinstance(c, VelocityConstraint) for c in system.constraints)
    if system.gravity is None or is_kinematic(system) or not model.nu or rolling:
        return
    try:
        found = linear_controllability(model, subject.rest)
    except KinolabError:
        return  # it does not rest there
    fastest = max((mode.real for mode in found.modes), default=0.0)
    if fastest > 0.05:  # [1/s] of a deviation: slower may be rounding of double zeros
        modes, ways = np.linalg.eig(model.jacobian(subject.rest, model.null_control())[0])
        way = np.abs(ways[:, np.argmin(np.abs(modes - fastest))]) / model.state_scales
        name = model.state_names[int(np.argmax(way[: model.nq]))]
        what = f"At rest it turns over or falls: a small {name} grows e-fold in {1 / fastest:.2g} "
        what += "s, and no input acts on that. Does a force hold it below its centre of mass that "
        what += "should do so above, as buoyancy does, or is a sign wrong?"
        yield Remark("turns over", name, what, ("System", system.name))


def pushed_down(subject: Subject) -> Iterator[Remark]:
    """Yield that all that inputs can do to what floats at rest is to push it down, or aside."""
    system, model, x = subject.system, subject.model, subject.rest
    if system.gravity is None or is_kinematic(system) or not model.nu:
        return
    try:
        centre = _centre(subject)
    except KinolabError:
        return
    if centre is None:
        return
    lift = -np.array(system.down or DOWN) @ centre
    idle = model.null_control()
    ends = [np.where(np.eye(model.nu, dtype=bool)[k], np.clip(end, -UNLIMITED, UNLIMITED), idle)
            for k in range(model.nu) for end in model.control_bounds[k]]  # fmt: skip
    weight, *lifts = (float(lift @ model.f(x, u)[model.speeds]) for u in (idle, *ends))
    gains = np.array(lifts) - weight
    if weight < 0 and gains.max() <= HELD * -weight and gains.min() < HELD * weight:
        k = int(np.argmin(gains)) // 2
        entry = system.inputs[k]
        what = (
            "As it stands at rest, no input can push it up, and this one pushes it down: it hovers "
            "upside down only. Is its force along an axis that points down, as z does where x is "
            "north and y east? Here gravity goes along "
            f"{direction_of(system.gravity)}."
        )
        yield Remark("pushes down", entry.name, what, (type(entry).__name__, entry.name))
    wings = any(isinstance(a, RateSymbol) for e in system.efforts if not e.size for v in loads_in(e)
                for a in atoms_of(v.magnitude))  # fmt: skip
    if weight < 0 and not wings and np.abs(gains).max() <= HELD * -weight:
        pushes = [centre @ (model.f(x, u) - model.f(x, idle))[model.speeds] for u in ends]
        sizes = np.linalg.norm(pushes, axis=1)
        box = np.vstack([model.state_bounds, model.control_bounds])
        starts = (np.append(one, idle) for one in random_states(model))
        if sizes.max() > HELD * -weight and any(
            _settled(subject, z, box)[1] <= 1e-3
            for z in starts  # as in without_rest
        ):
            entry = system.inputs[int(np.argmax(sizes)) // 2]
            what = "As it stands at rest, inputs push it aside, and none of them up: it hovers "
            what += "only where it has tipped over. Is its force along another axis, such as z?"
            yield Remark("pushes aside", entry.name, what, (type(entry).__name__, entry.name))


def _centre(subject: Subject) -> Array | None:
    """Return the velocity of the centre of mass by each velocity, (3, nv); None if nothing floats.

    It floats if all bodies may rise alike without turning.
    """
    system, model, x = subject.system, subject.model, subject.rest
    moving = []
    for one in np.eye(len(model.speeds)):
        begun = x.copy()
        begun[model.speeds] = one
        moving.append(model.f(begun, model.null_control())[: model.nq])
    slopes = subject.poses_by(x) @ np.array(moving).T  # of [R | p] by velocities
    masses = np.array([system.number(body.mass) for body in system.bodies])
    up = -np.array(system.down or DOWN)
    wanted = np.hstack([np.zeros((3, 3)), up[:, None]]).ravel()
    rows = np.vstack([slopes[k].reshape(12, -1) for k in np.flatnonzero(masses)])
    wanted = np.tile(wanted, np.count_nonzero(masses))
    raised = np.linalg.lstsq(rows, wanted, rcond=1e-9)[0]
    if not masses.any() or np.abs(rows @ raised - wanted).max() > HELD:
        return None
    return np.asarray(np.einsum("b,bij->ij", masses, slopes[:, :, 3]) / masses.sum())
