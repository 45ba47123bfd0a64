"""Equality constraints of MJCF files: joints that follow others, and what closes loops."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.robots.mjcf.compiled_model import CompiledModel
from kinolab.robots.tree.kinematic_tree import Closure, Mimicked, pose_of

CLOSING = ("connect", "weld")  # equality constraints that close loops


def _equalities(compiled: CompiledModel) -> Iterator[tuple[int, str]]:
    """Yield the equality constraints that hold, with their kinds in lower case."""
    model, mujoco = compiled.model, compiled.mujoco
    for k in np.flatnonzero(model.eq_active0).tolist():
        yield k, mujoco.mjtEq(int(model.eq_type[k])).name.removeprefix("mjEQ_").lower()


def followers(compiled: CompiledModel) -> dict[str, Mimicked]:
    """Return which joints follow others by a linear equality constraint."""
    model, found = compiled.model, {}
    names = compiled.names("EQUALITY", model.neq, "equality")
    for k, kind in _equalities(compiled):
        if kind in CLOSING:
            continue
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        polynomial = np.array(model.eq_data[k, :5])
        if kind == "joint" and second >= 0 and not polynomial[2:].any():
            own, leader = compiled.joints[first], compiled.joints[second]
            if own in found:
                compiled.cannot(f"equality constraint {names[k]}: joint {own} follows two others.")
                continue
            # q1 - q1(0) = a + b (q2 - q2(0))
            zeros = [float(model.qpos0[model.jnt_qposadr[j]]) for j in (first, second)]
            factor = float(polynomial[1])
            found[own] = Mimicked(leader, factor, zeros[0] + polynomial[0] - factor * zeros[1])
        else:
            what = f"equality constraint {names[k]}, {kind}, "
            if kind != "joint":
                compiled.cannot(f"{what}couples more than two joints, or what is no joint.")
            elif second < 0:
                compiled.cannot(f"{what}holds {compiled.joints[first]}.", "Use locked instead.")
            else:
                compiled.cannot(f"{what}has a polycoef that is not linear in the other joint.")
    return found


def closures(compiled: CompiledModel) -> Iterator[Closure]:
    """Yield what ``connect`` and ``weld`` hold together, bodies or sites."""
    model, names = compiled.model, compiled.names("EQUALITY", compiled.model.neq, "equality")
    site = int(compiled.mujoco.mjtObj.mjOBJ_SITE)
    for k, kind in _equalities(compiled):
        if kind not in CLOSING:
            continue
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        data = np.array(model.eq_data[k])
        welded = kind == "weld" and data[10] != 0.0  # the scale of its torque
        if int(model.eq_objtype[k]) == site:
            poses = [
                pose_of(model.site_pos[s], compiled.turn(model.site_quat[s]))
                for s in (first, second)
            ]
            first, second = (int(model.site_bodyid[s]) for s in (first, second))
        elif kind == "connect":
            poses = [pose_of(anchor, np.eye(3)) for anchor in (data[:3], data[3:6])]
        else:  # the second body's anchor comes first, then its pose in the first one's axes
            poses = [pose_of(data[3:6], compiled.turn(data[6:10])), pose_of(data[:3], np.eye(3))]
        ends = compiled.bodies[first], compiled.bodies[second]
        roots = (int(model.body_rootid[body]) for body in (first, second))
        if any(int(model.body_mocapid[root]) >= 0 for root in roots):
            what = f"equality constraint {names[k]} holds {ends[0]} and {ends[1]} together"
            compiled.cannot(f"{what}, of which one is a mocap body, moved from outside.")
            continue
        yield Closure(names[k], "pose" if welded else "point", *ends, *poses)
