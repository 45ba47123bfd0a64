"""What inputs act on: motors whose reaction nothing takes, and axes that turn away."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.analyze.examine.remark import Remark
from kinolab.analyze.examine.subject import Subject
from kinolab.dynamics import Axis, Body
from kinolab.dynamics.language.frames import AXES
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array

ALONG = 1e-6  # relative, of rounding in velocities
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
                what = f"{entry.name} pushes {on.name} against {found.name}, on which it "
                what += "is mounted, and the world takes the reaction, as of no motor. With "
                what += f"reacts_on={found.name} it pushes both."
                title = "no reaction"
                yield Remark(title, entry.name, what, (kind, entry.name))


def _carrier(subject: Subject, on: Body, axis: Axis, *, turns: bool) -> Body | None:
    """Return the moving body on which another is mounted, along the axis of an input."""
    own = subject.moving(on.frame)
    bases = [
        body
        for body in subject.system.bodies
        if (moving := subject.moving(body.frame)) and moving < own and not body.massless
    ]
    for base in sorted(bases, key=lambda body: -len(subject.moving(body.frame))):
        if _acts_between(subject, on, base, axis, turns=turns):
            return base
    return None


def _acts_between(subject: Subject, on: Body, base: Body, axis: Axis, *, turns: bool) -> bool:
    """Whether a body moves against its base along an axis alone, and the base along it, too."""
    x = subject.moved({c: SHARES[i % 3] for i, c in enumerate(subject.plain)})
    try:
        moving, _ = subject.in_motion(x)
    except KinolabError:
        return False
    direction = _axis(subject, axis, x)
    if direction is None:
        return False
    ours, bases = (_velocities(subject, body, x, turns=turns) for body in (on, base))
    only = [k for c, k in subject.plain.items() if c.name not in subject.moving(base.frame)]
    joint = np.stack([ours[:, k] for k in only], axis=1) if only else np.zeros((3, 0))
    joint = joint[:, np.linalg.norm(joint, axis=0) > ALONG]
    if joint.shape[1] != 1:
        return False
    along = abs(direction @ joint[:, 0]) / np.linalg.norm(joint[:, 0])
    carried = np.abs(moving @ bases.T @ direction).max(initial=0.0)
    return bool(along > 1 - ALONG and carried > ALONG * np.abs(moving).max(initial=1e-300))


def _velocities(subject: Subject, body: Body, x: Array, *, turns: bool) -> Array:
    """Return the angular velocity, or the centre's, by the rates of entries, shape (3, nq)."""
    k = subject.place_of(body)
    slope = subject.poses_by(x)[k]
    if not turns:
        return np.asarray(slope[:, 3])
    spin = np.einsum("ijk,lj->ilk", slope[:, :3], subject.poses(x)[k][:, :3])
    return np.asarray([spin[2, 1], spin[0, 2], spin[1, 0]])


def _axis(subject: Subject, axis: Axis, x: Array) -> Array | None:
    """Return an axis in the world at a state; None where its frame has what is no coordinate."""
    watched = Body("axis", axis.frame)
    try:
        twin = subject.system.changed(bodies=[*subject.system.bodies, watched], flat=None)
        pose = twin.model().frames(x)[-1].reshape(3, 4)
    except KinolabError:
        return None
    return np.asarray(pose[:, AXES[axis.name]])


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
