"""What inputs act on: motors whose reaction nothing takes, and axes that turn away."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Axis, Body
from kinolab.dynamics.language.frames import AXES, pose
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.mechanism_parts import atoms_of, configuration_symbols
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states

ALONG = 1e-6  # relative, of rounding in velocities
SEEN = 1e-3  # from which two directions are different: one minus the cosine
SHARES = (0.3, -0.2, 0.45)  # of the spans of coordinates, where axes are looked at


def reactions(subject: Subject) -> Iterator[Remark]:
    """Yield the motors between two moving bodies whose reaction the world takes."""
    for entry in subject.system.inputs:
        on, about = getattr(entry, "on", None), getattr(entry, "about", None)
        axis = about or getattr(entry, "along", None)
        if (
            isinstance(on, Body)
            and isinstance(axis, Axis)
            and getattr(entry, "reacts_on", on) is None
        ):
            found = _carrier(subject, on, axis, turns=about is not None)
            if found is not None:
                kind = type(entry).__name__
                what = f"{entry.name} acts between {on.name} and {found.name}, which moves, "
                what += "too, and the world takes the reaction, as of no motor. With "
                what += f"reacts_on={found.name} it pushes both."
                title = "no reaction"
                yield Remark(title, entry.name, what, (kind, entry.name))


def _carrier(subject: Subject, on: Body, axis: Axis, *, turns: bool) -> Body | None:
    """Return the moving body on which another is mounted, if a motor between them turns it, too."""
    x = _aside(subject)
    direction, at_rest = _axis(subject, axis, x), _axis(subject, axis, subject.rest)
    if direction is None or at_rest is None:
        return None
    mounts = [b for b in subject.carriers(on) if subject.moving(b.frame) and not b.massless]
    for base in mounts:
        own = subject.moving(on.frame) - subject.moving(base.frame)
        free = turns and any(c.name in own for c in subject.turning)
        joint = direction if free else _joint(subject, on, base, x, turns=turns)
        if joint is None or abs(direction @ joint) < 1 - ALONG:
            continue
        if _takes_part(subject, base, direction, x, turns=turns):
            return base
        # An axis that turns with its mount is none of the world's; wheels are driven at the ground.
        if turns and not on.touches_ground and abs(direction @ at_rest) < 1 - ALONG:
            return base
    return None if mounts or not turns else _beside(subject, on, direction, x)


def _beside(subject: Subject, on: Body, direction: Array, x: Array) -> Body | None:
    """Return the body that turns about the same axle as another, of which nothing is the mount."""
    own = subject.moving(on.frame)
    point, spin = _on_axle(subject, on, direction, x), subject.spin(on, x)
    for other in subject.system.bodies:
        theirs = subject.moving(other.frame)
        if other is on or other.massless or not own & theirs or not theirs - own:
            continue
        turning = spin - subject.spin(other, x)
        across = turning - np.outer(direction, direction @ turning)
        slip = subject.slip(on, other, point, x)  # none where both are on one axle
        joined = max(np.abs(across).max(), np.abs(slip).max()) < ALONG * max(1, np.abs(spin).max())
        if joined and np.abs(turning - spin).max() > ALONG:
            return other
    return None


def _on_axle(subject: Subject, on: Body, direction: Array, x: Array) -> Array:
    """Return a point of the axle about which a coordinate turns a body."""
    origin: Array = subject.poses(x)[subject.place_of(on)][:, 3]
    spin = direction @ subject.spin(on, x)
    for k in subject.plain.values():
        if abs(spin[k]) > ALONG:
            speed = subject.slip(on, None, origin, x)[:, k]
            return np.asarray(origin + np.cross(direction, speed) / spin[k])
    return np.asarray(origin)


def _aside(subject: Subject) -> Array:
    return subject.moved({c: SHARES[i % 3] for i, c in enumerate(subject.plain)})


def _joint(subject: Subject, on: Body, base: Body, x: Array, *, turns: bool) -> Array | None:
    """Return the direction in which alone a body moves against its base; None if in several."""
    ours = _velocities(subject, on, x, turns=turns)
    only = [k for c, k in subject.plain.items()
            if c.name in subject.moving(on.frame) - subject.moving(base.frame)]  # fmt: skip
    sizes = np.linalg.norm(ours[:, only], axis=0)
    if (sizes > ALONG).sum() != 1:
        return None
    k = int(np.argmax(sizes))
    return np.asarray(ours[:, only[k]] / sizes[k])


def _takes_part(subject: Subject, base: Body, direction: Array, x: Array, *, turns: bool) -> bool:
    """Whether a base moves along a direction, so that a reaction on it does work."""
    try:
        moving, _ = subject.in_motion(x)
    except KinolabError:
        return False
    along = moving @ _velocities(subject, base, x, turns=turns).T @ direction
    return bool(np.abs(along).max(initial=0.0) > ALONG * np.abs(moving).max(initial=1e-300))


def _velocities(subject: Subject, body: Body, x: Array, *, turns: bool) -> Array:
    """Return the angular velocity, or the centre's, by the rates of entries, shape (3, nq)."""
    if turns:
        return subject.spin(body, x)
    return np.asarray(subject.poses_by(x)[subject.place_of(body)][:, 3])


def _axis(subject: Subject, axis: Axis, x: Array) -> Array | None:
    """Return an axis in the world at a state; None where its frame has what is no coordinate."""
    system = subject.system
    values = system.substitutions
    values |= dict(zip(configuration_symbols(system), x[: subject.model.nq], strict=True))
    column = pose(axis.frame)[0][:, AXES[axis.name]].subs(values)
    return None if column.free_symbols else np.array(column, dtype=float)[:, 0]


def turned_away(subject: Subject) -> Iterator[Remark]:
    """Yield the motors between two bodies about another axis than that of their joint."""
    x = _aside(subject)
    for entry in subject.system.inputs:
        on, about = getattr(entry, "on", None), getattr(entry, "about", None)
        axis, base = about or getattr(entry, "along", None), getattr(entry, "reacts_on", None)
        if not (isinstance(on, Body) and isinstance(axis, Axis)):
            continue
        turns = about is not None
        bodies = [base] if base is not None else subject.carriers(on)[:1]
        for body in bodies:
            other, one = sorted((on, body), key=lambda b: len(subject.moving(b.frame)))
            if not subject.moving(other.frame) < subject.moving(one.frame):
                continue
            joint, way = _joint(subject, one, other, x, turns=turns), _axis(subject, axis, x)
            if joint is None or way is None or abs(joint @ way) >= 1 - SEEN:
                continue
            first, start = (_joint(subject, one, other, subject.rest, turns=turns),
                            _axis(subject, axis, subject.rest))  # fmt: skip
            if first is None or start is None or abs(first @ start) < 1 - ALONG:
                continue
            verb = "turns about" if turns else "slides along"
            what = f"Against {other.name}, {one.name} {verb} an axis that moves with the machine, "
            what += f"and {entry.name} acts {'about' if turns else 'along'} an axis that goes "
            what += "with it at rest only. Take the axis of a frame that moves with the joint, "
            what += "such as joint.y, and not one of the WORLD's."
            part = (type(entry).__name__, entry.name)
            yield Remark("axis of another direction than the joint's", entry.name, what, part)


def others_axes(subject: Subject) -> Iterator[Remark]:
    """Yield the forces and torques along an axis that turns with another body than they act on.

    By Newton's third law what pushes there is pushed: that body takes the reaction.
    """
    for entry in subject.system.inputs:
        on, base = getattr(entry, "on", None), getattr(entry, "reacts_on", None)
        axis = getattr(entry, "about", None) or getattr(entry, "along", None)
        if not (isinstance(on, Body) and isinstance(axis, Axis)):
            continue
        known = subject.moving(on.frame) | (subject.moving(base.frame) if base else frozenset())
        others = [c for c in subject.plain if c.name in subject.moving(axis.frame) - known]
        ways = [
            _axis(subject, axis, subject.moved(dict.fromkeys(others, s))) for s in (0, SHARES[0])
        ]
        if not others or ways[0] is None or ways[1] is None or ways[0] @ ways[1] >= 1 - SEEN:
            continue
        names = " and ".join(c.name for c in others)
        what = f"It acts on {on.name} {'about' if hasattr(entry, 'about') else 'along'} an axis "
        what += f"that turns with {names}, and {on.name} does not: it is the axis of another body. "
        what += f"Take that of a frame that goes with {on.name}, or the body that pushes it as "
        what += "reacts_on."
        part = (type(entry).__name__, entry.name)
        yield Remark("axis of another body", entry.name, what, part)


def _motors(subject: Subject, x: Array) -> Iterator[tuple[Input, Body, Body, Array]]:
    """Yield inputs between two bodies about an axis: what, on which, against which, the axis."""
    for entry in subject.system.inputs:
        on, base = getattr(entry, "on", None), getattr(entry, "reacts_on", None)
        about = getattr(entry, "about", None)
        if isinstance(on, Body) and isinstance(base, Body) and isinstance(about, Axis):
            direction = _axis(subject, about, x)
            if direction is not None:
                yield entry, on, base, direction


def parted_axles(subject: Subject) -> Iterator[Remark]:
    """Yield the motors between two bodies side by side that have no axle in common.

    What turns by them is on one shaft: some point of it is a point of both bodies, but for motions
    along it.
    """
    x = _aside(subject)
    for entry, on, base, direction in _motors(subject, x):
        ours, theirs = subject.moving(on.frame), subject.moving(base.frame)
        if ours <= theirs or theirs <= ours:
            continue
        spin = (subject.spin(on, x) - subject.spin(base, x)).T  # (nq, 3)
        origin = subject.poses(x)[subject.place_of(on)][:, 3]
        slip = subject.slip(on, base, origin, x).T
        across = np.eye(3) - np.outer(direction, direction)
        # slip + spin x p = 0 across the axle, at some p
        rows = np.vstack([across @ np.cross(w, np.eye(3)).T for w in spin])
        wanted = -(slip @ across).ravel()
        left = rows @ np.linalg.lstsq(rows, wanted, rcond=None)[0] - wanted
        if np.abs(left).max() > SEEN * max(np.abs(wanted).max(), ALONG):
            names = " and ".join(sorted((ours ^ theirs) & {c.name for c in subject.plain}))
            what = f"{entry.name} acts between them, and they have no axle in common: they part as "
            what += f"{names} move. What is mounted on a body has a frame that begins with that "
            what += "body's."
            title = f"{on.name} and {base.name}"
            yield Remark("carried at rest only", title, what, (type(entry).__name__, entry.name))


def passed_joints(subject: Subject) -> Iterator[Remark]:
    """Yield the motors that react on a body beyond the one on whose joint they act."""
    x = _aside(subject)
    for entry, on, base, direction in _motors(subject, x):
        known = subject.moving(base.frame)
        for mount in (b for b in subject.carriers(on)[:1] if known < subject.moving(b.frame)):
            joint = _joint(subject, on, mount, x, turns=True)
            if joint is not None and abs(joint @ direction) > 1 - ALONG:
                what = f"{on.name} turns about that axis on {mount.name}, and {entry.name} reacts "
                what += f"on {base.name}, beyond it: is it reacts_on={mount.name}? Only a belt or "
                what += f"a shaft past {mount.name} turns it so."
                part = (type(entry).__name__, entry.name)
                yield Remark("reacts beyond its joint", entry.name, what, part)


def turning_axes(subject: Subject) -> Iterator[Remark]:
    """Yield the torques about an axis that a wheel's own roll turns away."""
    for entry in subject.system.inputs:
        on, about = getattr(entry, "on", None), getattr(entry, "about", None)
        if not (isinstance(on, Body) and isinstance(about, Axis)):
            continue
        last = about.frame.motions[-1:] if about.frame == on.frame else ()
        round_about = {shape.axis for shape in on.shapes if shape.symmetric == "z"}
        for motion in last:
            name, angle = getattr(motion, "axis", ""), getattr(motion, "angle", None)
            unlimited = any(c in angle.free_symbols and not np.isfinite([c.lower, c.upper]).any()
                            for c in subject.plain) if angle is not None else False  # fmt: skip
            if name in round_about and about.name != name and unlimited:
                what = f"{entry.name} acts about the {about.name} axis of {on.name}, "
                what += f"which turns as it rolls ({angle}): after half a turn it acts the other "
                what += "way round. Take an axis of the frame before that rotation."
                yield Remark(
                    "axis that rolls along", entry.name, what, (type(entry).__name__, entry.name)
                )


def without_effect(subject: Subject) -> Iterator[Remark]:
    """Yield the torques and forces that do nothing, wherever the machine is."""
    effects = _effects(subject)
    most = max((float(np.abs(e).max(initial=0.0)) for e in effects), default=0.0)
    for k, entry in enumerate(subject.system.inputs):
        on, base = getattr(entry, "on", None), getattr(entry, "reacts_on", None)
        axis = getattr(entry, "about", None) or getattr(entry, "along", None)
        # 1e-12 of the largest effect of an input: rounding of a sum that vanishes
        idle = effects and all(np.abs(e[:, k]).max() <= 1e-12 * most for e in effects)
        if not (idle and isinstance(on, Body) and isinstance(axis, Axis)):
            continue
        if base == on:
            what = f"It acts on {on.name} and reacts on {on.name}, the same body: on nothing."
        else:
            turns = hasattr(entry, "about")
            against = f"against {base.name}" if isinstance(base, Body) else "in the world"
            what = f"It acts {'about' if turns else 'along'} the {axis.name} axis of a frame, and "
            what += f"{on.name} never {'turns about' if turns else 'moves along'} that {against}. "
            what += "Take the axis of its joint."
        yield Remark("no effect", entry.name, what, (type(entry).__name__, entry.name))


def _effects(subject: Subject) -> list[Array]:
    """Return what inputs do to the rates of a state at a few states, shape (nx, nu) each."""
    model = subject.model
    try:
        return [model.jacobian(x, model.null_control())[1] for x in random_states(model)]
    except KinolabError:
        return []


def same_effects(subject: Subject) -> Iterator[Remark]:
    """Yield the inputs that do what another one does there, wherever the machine is.

    Two bodies may be pushed alike, as by two motors, unless one of them waits for its own push.
    """
    system, model = subject.system, subject.model
    acting, effects = [_acted_on(subject, e) for e in system.inputs], _effects(subject)
    moving = [
        {c for b in system.bodies if b.name in names for c in subject.moving(b.frame)}
        for names in acting
    ]
    for j, k in combinations(range(model.nu if effects else 0), 2):
        waiting = (moving[j] ^ moving[k]) - subject.pushed
        if not acting[j] or (acting[j] != acting[k] and not waiting):
            continue
        one, other = np.concatenate([e[:, [j, k]] for e in effects]).T
        ratio = float(one @ other) / max(float(one @ one), 1e-300)
        if ratio > 0 and np.abs(other - ratio * one).max() <= ALONG * np.abs(other).max():
            first, second = subject.system.inputs[j], subject.system.inputs[k]
            what = f"{second.name} does the same as {first.name}, {ratio:.3g} times as much, "
            what += (
                f"wherever the machine is: both act on {' and '.join(sorted(acting[j]))} alike. "
                if acting[j] == acting[k]
                else f"wherever it is, and nothing drives {' and '.join(sorted(waiting))}. "
            )
            what += "Do on=, about= or along= stand there from another line, or was at= left out?"
            yield Remark("same effect", second.name, what, (type(second).__name__, second.name))
            return


def _acted_on(subject: Subject, entry: Input) -> frozenset[str]:
    """Return the names of the bodies on which an input acts by itself or in forces."""
    users = (e for e in subject.system.efforts if entry.symbol in set(atoms_of(e)))
    words = [entry, *users]
    bodies = (getattr(w, key, None) for w in words for key in ("on", "reacts_on"))
    return frozenset(body.name for body in bodies if isinstance(body, Body))
