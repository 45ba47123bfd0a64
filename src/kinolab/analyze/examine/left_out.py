"""What was left out: a parameter, a mass, a rest length or a friction that others have."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from kinolab.analyze.examine.remarks.place_in_file import declared_with
from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Body, Parameter, System
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.mechanism_parts import atoms_of, energies_in, loads_in
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.dynamics.symbols.symbols import RateSymbol


def unheeded(system: System, file: Path | None) -> Iterator[Remark]:
    """Yield the parameters that a machine's function declares and that stand nowhere in it."""
    known = {p.name for p in system.parameters}
    for name, unit in declared_with(file, system.name):
        if name not in known:
            what = "It is declared, and stands in no frame, body, force or constraint of "
            what += f"{system.name}: what should have it was left out"
            what += ", such as gravity=toward(…)." if unit == "m/s^2" else ", or take it out."
            yield Remark("unused parameter", name, what, ("parameter", name))


def left_out(subject: Subject) -> Iterator[Remark]:
    """Yield the parts that lack what others of their kind have."""
    yield from _masses(subject)
    yield from _weightless(subject)
    yield from _lengths(subject)
    yield from _frictions(subject)


def _masses(subject: Subject) -> Iterator[Remark]:
    """Yield the bodies without a mass in whose inertia a mass stands that no body has.

    The mass of a wheel may count as one of what carries its axle.
    """
    bodies = subject.system.bodies
    weighed = {atom for body in bodies for atom in atoms_of((body.mass,))}
    for body in bodies:
        own = [a for a in atoms_of(tuple(body.inertia_matrix)) if isinstance(a, Parameter)]
        masses = [p.name for p in own if p.unit == "kg" and p not in weighed]
        if masses and is_zero(body.mass) and not _carried(subject, body):
            what = f"{masses[0]} stands in its moments of inertia and in no mass: it has none. "
            what += f"Body(…, mass={masses[0]}) gives it one."
            yield Remark("inertia without a mass", body.name, what, ("Body", body.name))


def _weightless(subject: Subject) -> Iterator[Remark]:
    """Yield the moving bodies on which motors react and which have nothing to be moved."""
    system = subject.system
    if is_kinematic(system):
        return
    links = {subject.moving(body.frame) for body in system.bodies if not body.massless}
    for entry in system.inputs:
        body = getattr(entry, "reacts_on", None)
        if not (isinstance(body, Body) and body.shapes and subject.moving(body.frame)):
            continue
        if subject.moving(body.frame) not in links:
            what = f"{entry.name} reacts on it, and neither it nor what is fixed to it has a mass "
            what += "or an inertia: Body(…, mass=…, inertia=…)."
            yield Remark("no mass", body.name, what, ("Body", body.name))
            return


def _carried(subject: Subject, body: Body) -> bool:
    """Whether a body turns about its origin on another one that has a mass."""
    x = subject.rest
    origin = subject.poses(x)[subject.place_of(body)][:, 3]
    size = np.abs(subject.slip(body, None, origin, x)).max(initial=0.0)
    # 1e-9 relative to how fast a body's origin moves
    return any(
        np.abs(subject.slip(body, base, origin, x)).max() <= 1e-9 * size
        for base in subject.carriers(body)
        if not is_zero(base.mass)
    )


def _lengths(subject: Subject) -> Iterator[Remark]:
    """Yield the springs without a rest length beside others that have one."""
    springs = [e for e in subject.system.efforts if hasattr(e, "stiffness") and not e.size]
    short = [e for e in springs if is_zero(e.length)]  # type: ignore[attr-defined]
    if short and len(short) < len(springs):
        for spring in short:
            ends = " and ".join(_end(subject, frame) for frame in spring.between)  # type: ignore[attr-defined]
            what = "It pulls its ends together until they meet, as its rest length is 0, and "
            what += "other springs of the machine have one: length= was left out."
            part = (type(spring).__name__, "")
            yield Remark("spring without a length", ends, what, part)


def _end(subject: Subject, frame: object) -> str:
    body = next((b.name for b in subject.system.bodies if b.frame == frame), None)
    moving = " and ".join(sorted(subject.moving(frame)))  # type: ignore[arg-type]
    return body or (f"the frame of {moving}" if moving else "a fixed point")


def _frictions(subject: Subject) -> Iterator[Remark]:
    """Yield the coordinate that has a friction twice where others of its unit have none."""
    frictions = [e for e in subject.system.efforts if e.size and not any(energies_in(e))]
    kinds = Counter(
        (type(e).__name__, *(written(v.velocity) for v in loads_in(e))) for e in frictions
    )
    rubbed = {
        a for e in frictions for load in loads_in(e) for a in atoms_of((written(load.velocity),))
    }
    for (kind, *velocities), count in kinds.items():
        rate = velocities[0]
        if count == 1 or not isinstance(rate, RateSymbol):
            continue
        unit = rate.coordinate.unit
        bare = [c for c in subject.plain if c.unit == unit and RateSymbol(c) not in rubbed]
        if bare:
            none = " and ".join(str(RateSymbol(c)) for c in bare)
            what = (
                f"{rate} has {count} of it, and {none} {'have' if bare[1:] else 'has'} none: the "
            )
            what += "lines are alike, and one was not changed."
            yield Remark("friction twice", str(rate), what, (kind, ""))
