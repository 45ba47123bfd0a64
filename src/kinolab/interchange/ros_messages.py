"""A motion as messages of ROS 2, in plain tables as ``ros2 topic pub`` takes them.

Source: ROS 2's interface definitions trajectory_msgs, nav_msgs, sensor_msgs and tf2_msgs; REP 103
(units and axes).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics import Model
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_poses
from kinolab.problem import PlanningTask
from kinolab.robots.writing.fresh_names import fresh_name
from kinolab.trajectory import Trajectory

WORLD = "world"  # what all poses are relative to
NANOSECONDS = 1_000_000_000

Message = dict[str, Any]


@checked
def joint_trajectory(
    problem: PlanningTask, trajectory: Trajectory, joints: Sequence[str] | None = None
) -> Message:
    """Return a motion as ``trajectory_msgs/msg/JointTrajectory``.

    Positions and velocities at the knots: a controller that joins them by cubics follows the
    motion with an error of order h^4 for knots h apart. Efforts are what the inputs exert along
    each joint, held from each point to the next, in [N m] or [N]; there are none where joints
    depend on each other, or have no masses. Accelerations jump where inputs do, so there are none.

    Args:
        problem: The problem of the motion.
        trajectory: The motion.
        joints: Names of coordinates; all that are single numbers when left out.

    Raises:
        InputError: If there are no such coordinates.
    """
    names = _joints(problem.model, joints)
    positions, velocities = _joint_states(problem.model, trajectory, names)
    efforts = _efforts(problem.model, trajectory, names)
    return {
        "header": header(0.0, ""),
        "joint_names": list(names),
        "points": [
            {
                "positions": q.tolist(),
                "velocities": v.tolist(),
                "accelerations": [],
                "effort": effort.tolist(),
                "time_from_start": stamp(float(t)),
            }
            for t, q, v, effort in zip(trajectory.t, positions, velocities, efforts, strict=True)
        ],
    }


def has_joints(problem: PlanningTask) -> bool:
    """Whether a machine has a coordinate that is a single number, as a joint has."""
    return any(len(c.entries) == 1 for c in problem.machine.coordinates)


def end_speeds(message: Message) -> dict[str, float]:
    """Return the velocities of a joint trajectory's last point that are not zero, by joint.

    ROS 2's joint_trajectory_controller refuses a trajectory that has any, unless its parameter
    ``allow_nonzero_velocity_at_trajectory_end`` says otherwise.
    """
    last = zip(message["joint_names"], message["points"][-1]["velocities"], strict=True)
    # That controller's own threshold, in [rad/s] or [m/s].
    return {name: speed for name, speed in last if abs(speed) > float(np.finfo(np.float32).eps)}


@checked
def path_message(problem: PlanningTask, trajectory: Trajectory, body: str | None = None) -> Message:
    """Return the poses of a body as ``nav_msgs/msg/Path``, in the frame ``world``.

    Args:
        problem: The problem of the motion.
        trajectory: The motion.
        body: Its name; the first one that moves when left out.

    Raises:
        InputError: If there is no such body.
    """
    poses = problem.model.frames(trajectory.x)
    names = [each.name for each in problem.bodies]
    if body is not None and body not in names:
        raise UnknownNameError("body", body, known=names, where="path_message")
    # 1e-9: by which some number of a pose differs if a body moves at all
    moves = (np.ptp(poses, axis=0) > 1e-9).any(axis=1)
    index = int(moves.argmax()) if body is None else names.index(body)
    places, turns = poses[:, index, 3::4], of_poses(poses[:, index])
    stamped = zip(trajectory.t, places, turns, strict=True)
    return {
        "header": header(0.0),
        "poses": [
            {
                "header": header(float(t)),
                "pose": {"position": point(place), "orientation": quaternion(turn)},
            }
            for t, place, turn in stamped
        ],
    }


def joint_state(problem: PlanningTask, trajectory: Trajectory) -> list[Message]:
    """Return a motion as ``sensor_msgs/msg/JointState``, one message per knot."""
    whole = joint_trajectory(problem, trajectory)
    return [
        {
            "header": {"stamp": each["time_from_start"], "frame_id": WORLD},
            "name": whole["joint_names"],
            "position": each["positions"],
            "velocity": each["velocities"],
            "effort": each["effort"],
        }
        for each in whole["points"]
    ]


def transforms(problem: PlanningTask, trajectory: Trajectory) -> list[Message]:
    """Return the poses of all bodies as ``tf2_msgs/msg/TFMessage``, one message per knot."""
    poses = problem.model.frames(trajectory.x)
    children = frame_names([body.name for body in problem.bodies])
    found = []
    for t, row in zip(trajectory.t, poses, strict=True):
        turns, at = of_poses(row), header(float(t))
        found.append(
            {
                "transforms": [
                    {
                        "header": at,
                        "child_frame_id": child,
                        "transform": {
                            "translation": point(pose[3::4]),
                            "rotation": quaternion(turn),
                        },
                    }
                    for child, pose, turn in zip(children, row, turns, strict=True)
                ]
            }
        )
    return found


def frame_names(names: Sequence[str]) -> list[str]:
    """Return names of frames: letters, digits and underscores, each of its own."""
    taken = {WORLD}
    return [fresh_name(re.sub(r"\W", "_", name, flags=re.ASCII), taken, "_") for name in names]


def stamp(t: float) -> Message:
    """Return a time in [s] as ``builtin_interfaces/msg/Time`` or ``Duration``."""
    sec, nanosec = divmod(nanoseconds(t), NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def nanoseconds(t: float) -> int:
    """Return a time in [s] in nanoseconds."""
    return round(t * NANOSECONDS)


def header(t: float, frame: str = WORLD) -> Message:
    """Return a ``std_msgs/msg/Header``."""
    return {"stamp": stamp(t), "frame_id": frame}


def point(place: Array) -> Message:
    """Return a position (3,) in [m]."""
    return dict(zip("xyz", place.tolist(), strict=True))


def quaternion(turn: Array) -> Message:
    """Return a unit quaternion x, y, z, w, shape (4,)."""
    return dict(zip("xyzw", turn.tolist(), strict=True))


def _joints(model: Model, wanted: Collection[str] | None) -> tuple[str, ...]:
    known = tuple(c.name for c in model.machine.coordinates if len(c.entries) == 1)
    if not known:
        what = "it has no coordinate that is a single number, as a joint has."
        raise InputError([Mistake(f"system {model.machine.name!r}", what, "Write a path.")])
    for name in wanted or ():
        if name not in known:
            raise UnknownNameError("joint", name, known=known, where="joint_trajectory")
    return known if wanted is None else tuple(wanted)


def _joint_states(
    model: Model, trajectory: Trajectory, names: Sequence[str]
) -> tuple[Array, Array]:
    """Return positions and velocities of joints at the knots, shapes (N+1, joints).

    Velocities that are inputs jump at knots; those after it count, at the last one those before.
    """
    held = trajectory.inputs
    u = held[np.minimum(np.arange(len(trajectory.t)), len(held) - 1)] if len(held) else ()
    rates = model.velocity(trajectory.x, u)
    rate_of = {c.name: c.rates[0] for c in model.machine.coordinates if len(c.entries) == 1}
    columns = [model.coordinate_names.index(name) for name in names]
    speeds = [model.rate_names.index(rate_of[name]) for name in names]
    return trajectory.x[:, columns], rates[:, speeds]


def _efforts(model: Model, trajectory: Trajectory, names: Sequence[str]) -> Array:
    """Return what inputs exert along joints, M(q) (a(x, u) - a(x, 0)), shape (N+1, joints).

    There are no columns where that is no force of the inputs alone: where rates are inputs or
    depend on each other, or a force has a state of its own.
    """
    plant, held = model.plant, trajectory.u
    machine, rates = plant.machine, list(plant.rate_names)
    dependent = machine.constraints or not {*rates} <= {*plant.state_names}
    moved = any("/s" in entry.unit for entry in machine.inputs)
    if dependent or moved or machine.states or machine.modes or not held.size:
        return np.zeros((len(trajectory.t), 0))
    u = held[np.minimum(np.arange(len(trajectory.t)), len(held) - 1)]
    pushed = plant.f(trajectory.x, u) - plant.f(trajectory.x, np.zeros_like(u))
    mass = plant.mass_matrix(plant.configuration(trajectory.x))
    exerted = np.einsum("kij,kj->ki", mass, pushed[:, [*map(plant.state_names.index, rates)]])
    rate_of = {c.name: c.rates[0] for c in machine.coordinates}
    return np.asarray(exerted[:, [rates.index(rate_of[name]) for name in names]])
