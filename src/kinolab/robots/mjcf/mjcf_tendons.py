"""Tendons of MJCF files: fixed ones, whose lengths are sums of joints' positions.

Source: MuJoCo's documentation, XML reference, tendon; chapter Computation, passive forces.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from kinolab.robots.actuation.actuators import Length, Tendon
from kinolab.robots.mjcf.compiled_model import CompiledModel

RESISTING = ("stiffness", "damping", "frictionloss", "armature")


def length_of(compiled: CompiledModel, tendon: int) -> Length | None:
    """Return a tendon's length as a sum of joints' positions; None of one along a path in space."""
    model, joints = compiled.model, dict[str, float]()
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    for w in range(first, first + count):
        if int(model.wrap_type[w]) != int(compiled.mujoco.mjtWrap.mjWRAP_JOINT):
            return None
        name = compiled.joints[int(model.wrap_objid[w])]
        joints[name] = joints.get(name, 0.0) + float(model.wrap_prm[w])
    return Length(joints)


def tendons(compiled: CompiledModel) -> Iterator[Tendon]:
    """Yield the tendons that resist a change of their lengths, or limit these."""
    model = compiled.model
    names = compiled.names("TENDON", model.ntendon, "tendon")
    for k, name in enumerate(names):
        own = {word: compiled.powers(f"tendon_{word}", k) for word in RESISTING}
        limited, along = bool(model.tendon_limited[k]), length_of(compiled, k)
        given = own | ({"range": compiled.powers("tendon_range", k)} if limited else {})
        acting = {word: values for word, values in given.items() if any(values)}
        if along is None:
            for word, values in acting.items():
                shown = " ".join(f"{value:g}" for value in values)
                what = f"tendon {name} has {word} {shown}, and is no sum of joints' positions."
                compiled.cannot(what, "Fixed tendons are read.")
        elif acting:
            shortest, longest = map(float, model.tendon_lengthspring[k])
            yield Tendon(
                name,
                along,
                stiffness=own["stiffness"],
                rest=(shortest, longest),
                damping=own["damping"],
                friction=sum(own["frictionloss"]),
                armature=sum(own["armature"]),
                lower=float(model.tendon_range[k, 0]) if limited else -math.inf,
                upper=float(model.tendon_range[k, 1]) if limited else math.inf,
            )
