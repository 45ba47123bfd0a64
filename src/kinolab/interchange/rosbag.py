"""A motion as a bag of ROS 2: a folder with an MCAP file and ``metadata.yaml``."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.interchange.ros_messages import (
    Message,
    has_joints,
    joint_state,
    joint_trajectory,
    nanoseconds,
    path_message,
    transforms,
)
from kinolab.lazy import library_of
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory


def write_bag(folder: Path, problem: PlanningTask, trajectory: Trajectory) -> None:
    """Write a motion as a bag that ``ros2 bag play`` and Foxglove read.

    Its topics are ``/joint_trajectory`` and ``/path``, whole, at the beginning, and ``/tf`` with
    the poses of all bodies and ``/joint_states``, 50 times a second. A machine without joints has
    only ``/path`` and ``/tf``.

    Args:
        folder: Must not exist yet.
        problem: The problem of the motion.
        trajectory: The motion.

    Raises:
        InputError: If the folder exists, or rosbags is not installed.
    """
    rosbag2 = library_of("ros", "rosbags.rosbag2", "bags of ROS 2 need rosbags")
    typesys = library_of("ros", "rosbags.typesys", "bags of ROS 2 need rosbags")
    if folder.exists():
        raise InputError([Mistake(str(folder), "it exists already.", "Name a new folder.")])
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as draft:
        whole = Path(draft) / folder.name
        # Version 9 of the metadata: ROS 2 Iron and later; Humble reads it, too
        with rosbag2.Writer(whole, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
            connections: dict[str, Any] = {}
            for topic, kind, time, content in _messages(problem, trajectory):
                if topic not in connections:
                    connections[topic] = bag.add_connection(topic, kind, typestore=store)
                data = store.serialize_cdr(_made(store, kind, content), kind)
                bag.write(connections[topic], nanoseconds(time), data)
        shutil.move(whole, folder)


def _messages(
    problem: PlanningTask, trajectory: Trajectory
) -> Iterator[tuple[str, str, float, Message]]:
    """Yield topic, type, time in [s] and content."""
    if jointed := has_joints(problem):
        whole = joint_trajectory(problem, trajectory)
        yield "/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", 0.0, whole
    yield "/path", "nav_msgs/msg/Path", 0.0, path_message(problem, trajectory)
    fine = _sampled(trajectory)
    states = joint_state(problem, fine) if jointed else []
    for k, (t, poses) in enumerate(zip(fine.t, transforms(problem, fine), strict=True)):
        yield "/tf", "tf2_msgs/msg/TFMessage", float(t), poses
        if states:
            yield "/joint_states", "sensor_msgs/msg/JointState", float(t), states[k]


def _sampled(trajectory: Trajectory) -> Trajectory:
    """Return the motion at evenly spaced times."""
    begin, end = float(trajectory.t[0]), float(trajectory.t[-1])
    # 50.0 [Hz] at which joints and transforms are told
    times = np.linspace(begin, end, max(round((end - begin) * 50.0), 1) + 1)
    if len(trajectory.t) == 1:
        return trajectory
    moments = trajectory.at(times)
    u, references = moments.u[:-1], moments.references[:-1]
    return replace(trajectory, t=times, x=moments.x, u=u, references=references)


def _made(store: Any, kind: str, content: Mapping[str, Any]) -> Any:
    """Return a message of a type from a table with all its fields."""
    _, fields = store.fielddefs[kind]
    return store.types[kind](**{name: _value(store, of, content[name]) for name, of in fields})


def _value(store: Any, of: tuple[Any, Any], content: Any) -> Any:
    node, detail = of
    if node.name == "NAME":
        return _made(store, detail, content)
    if node.name == "SEQUENCE":
        inner, _ = detail
        if inner == (inner[0], ("float64", 0)):
            return np.array(content, dtype=np.float64)
        return [_value(store, inner, entry) for entry in content]
    return content
