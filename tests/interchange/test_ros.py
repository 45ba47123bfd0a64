"""Messages of ROS 2: their definitions and a reader of bags that others wrote are the judges."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import kinolab
from kinolab import dynamics as kd
from kinolab.errors import InputError
from kinolab.interchange import export_motion, joint_trajectory, path_message
from kinolab.interchange.ros_messages import end_speeds

make_reader = pytest.importorskip("mcap.reader").make_reader
DecoderFactory = pytest.importorskip("mcap_ros2.decoder").DecoderFactory
AnyReader = pytest.importorskip("rosbags.highlevel").AnyReader
typesys = pytest.importorskip("rosbags.typesys")

STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)


@pytest.fixture(scope="module")
def swing() -> tuple[Any, Any]:
    """A pendulum of 1 m that swings freely from 0.5 rad."""
    problem = kinolab.load({"system": "pendulum", "goal": {"theta": 3.0}})
    return problem, kinolab.simulate(problem, duration=1.0, start={"theta": 0.5})


def fields(kind: str) -> set[str]:
    """Return the fields of a message, as its definition says."""
    return {name for name, _ in STORE.fielddefs[kind][1]}


def decoded(folder: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return the messages of a bag by topic, as the package mcap reads them."""
    found = defaultdict(list)
    with next(folder.glob("*.mcap")).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time, content))
    return dict(found)


def test_a_joint_trajectory_has_the_fields_of_its_definition(swing, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = export_motion(tmp_path / "j.yaml", *swing, "joint_trajectory")
    message = yaml.safe_load(path.read_text())
    assert set(message) == fields("trajectory_msgs/msg/JointTrajectory")
    assert set(message["points"][0]) == fields("trajectory_msgs/msg/JointTrajectoryPoint")
    assert message["joint_names"] == ["theta"]


def test_cubics_through_its_points_conserve_energy(swing) -> None:  # type: ignore[no-untyped-def]
    """As a controller joins them; velocities of other positions would not."""
    problem, motion = swing
    message = joint_trajectory(problem, motion)
    times = [
        p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"]
        for p in message["points"]
    ]
    q = np.array([p["positions"][0] for p in message["points"]])
    v = np.array([p["velocities"][0] for p in message["points"]])
    assert np.abs(np.array(times) - motion.t).max() < 1e-9
    h = np.diff(times)
    middle = (q[:-1] + q[1:]) / 2 + h / 8 * (v[:-1] - v[1:])
    rate = 1.5 * np.diff(q) / h - (v[:-1] + v[1:]) / 4
    energy = [sum(problem.model.energy([a, b])) for a, b in zip(middle, rate, strict=True)]
    first = sum(problem.model.energy([0.5, 0.0]))
    assert np.ptp(q) > 0.5
    assert np.abs(np.array(energy) - first).max() < 1e-4 * abs(first)


def test_a_path_has_unit_quaternions_and_the_definition_s_fields(tmp_path: Path) -> None:
    problem = kinolab.load("rolling_disk_maze")
    motion = kinolab.simulate(problem, lambda *_: [0.3, 0.1], duration=1.0)
    message = yaml.safe_load(
        export_motion(tmp_path / "p.yaml", problem, motion, "path").read_text()
    )
    assert set(message) == fields("nav_msgs/msg/Path")
    assert message["header"]["frame_id"] == "world"
    poses = [entry["pose"] for entry in message["poses"]]
    assert [p["position"]["x"] for p in poses] == pytest.approx(motion.x[:, 0].tolist())
    sizes = [sum(value**2 for value in p["orientation"].values()) for p in poses]
    assert sizes == pytest.approx([1.0] * len(poses))


def test_the_package_mcap_reads_a_bag(swing, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    problem, motion = swing
    folder = export_motion(tmp_path / "bag", problem, motion, "rosbag")
    found = decoded(folder)
    assert set(found) == {"/joint_trajectory", "/path", "/tf", "/joint_states"}
    times = np.array([time for time, _ in found["/joint_states"]]) * 1e-9
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(1.0)
    assert np.abs(np.diff(times) - 0.02).max() < 1e-6
    first = found["/joint_states"][0][1]
    assert (list(first.name), list(first.position)) == (["theta"], [0.5])
    sent = [np.array(p.positions) for p in found["/joint_trajectory"][0][1].points]
    assert np.array_equal(np.ravel(sent), motion.x[:, 0])
    stamps = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for _, m in found["/joint_states"]]
    assert stamps == pytest.approx(times.tolist())


def test_transforms_in_a_bag_are_where_the_bob_is(swing, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """Joint angle and pose of the same moment belong together: the bob is on its circle."""
    found = decoded(export_motion(tmp_path / "bag", *swing, "rosbag"))
    names = [t.child_frame_id for t in found["/tf"][0][1].transforms]
    assert len(set(names)) == len(names)
    angles, places = [], []
    for (_, joints), (_, poses) in zip(found["/joint_states"], found["/tf"], strict=True):
        place = poses.transforms[names.index("bob")].transform.translation
        angles.append(joints.position[0])
        places.append([place.x, place.y, place.z])
    plane = np.array(places)[:, np.ptp(places, axis=0) > 1e-6]
    assert plane.shape[1] == 2
    assert np.ptp(np.linalg.norm(plane, axis=1)) < 1e-9
    turned = np.unwrap(np.arctan2(*plane.T))
    turned *= np.sign(turned[-1] - turned[0]) * np.sign(angles[-1] - angles[0])
    assert turned - turned[0] == pytest.approx(np.array(angles) - angles[0], abs=1e-9)


def test_rosbags_own_reader_opens_the_folder(swing, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    folder = export_motion(tmp_path / "bag", *swing, "rosbag")
    with AnyReader([folder]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections}["/tf"] == "tf2_msgs/msg/TFMessage"


def test_a_bag_is_not_written_over_another_one(swing, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    export_motion(tmp_path / "bag", *swing, "rosbag")
    with pytest.raises(InputError, match=r"it exists already. Name a new folder"):
        export_motion(tmp_path / "bag", *swing, "rosbag")
    assert [entry.name for entry in tmp_path.iterdir()] == ["bag"]


def test_joints_and_bodies_are_chosen_by_name(swing) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=r"no joint is called 'elbow'.*theta"):
        joint_trajectory(*swing, joints=["elbow"])
    with pytest.raises(InputError, match=r"no body is called 'hand'"):
        path_message(*swing, body="hand")


def test_a_machine_without_joints_has_a_path_and_transforms(tmp_path: Path) -> None:
    turned = kd.rotation("R", speed=2.0)
    body = kd.Body("top", kd.orient(turned), mass=1, inertia=1, shape=kd.Sphere(0.1))
    frame = body.frame
    motors = [kd.Torque(n, on=body, about=getattr(frame, n), limit=1.0) for n in "xyz"]
    top = kd.System("top", bodies=[body], inputs=motors)
    problem = kinolab.load({"system": top, "goal": {"R": [0.0, 0.0, 0.6, 0.8]}})
    motion = kinolab.simulate(problem, lambda *_: [0.5, 0.0, 0.1], duration=0.5)
    with pytest.raises(InputError, match="no coordinate that is a single number"):
        joint_trajectory(problem, motion)
    found = decoded(export_motion(tmp_path / "bag", problem, motion, "rosbag"))
    assert set(found) == {"/path", "/tf"}


@pytest.mark.parametrize(
    ("name", "exerts"),
    [
        ("pendulum", lambda u: u),  # about its only joint
        ("acrobot_v0", lambda u: np.column_stack([np.zeros(len(u)), u])),  # about the elbow alone
    ],
)
def test_efforts_are_those_of_the_motors(name: str, exerts: Any) -> None:
    pushes = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 1))
    problem = kinolab.load({"system": name, "goal": {}})
    motion = kinolab.simulate(problem, lambda t, _: pushes[round(t / 0.05)], duration=1.0)
    points = joint_trajectory(problem, motion)["points"]
    efforts = np.array([point["effort"] for point in points])
    assert np.abs(efforts[:-1] - exerts(motion.u)).max() < 1e-12  # [N m]


def test_speeds_that_are_inputs_take_no_effort() -> None:
    problem = kinolab.load({"system": "unicycle1_v0", "bounds": {"x": [-9, 9], "y": [-9, 9]}})
    motion = kinolab.simulate(problem, lambda *_: [0.2, 0.1], duration=0.5)
    assert all(not point["effort"] for point in joint_trajectory(problem, motion)["points"])


def test_a_last_velocity_that_is_not_zero_is_told(swing: tuple[Any, Any]) -> None:
    """ROS 2's controller refuses such a trajectory."""
    problem, motion = swing
    assert end_speeds(joint_trajectory(problem, motion)) == {"theta": motion.x[-1, 1]}
    rest = kinolab.simulate(problem, duration=1.0, start={"theta": 0.0})
    assert end_speeds(joint_trajectory(problem, rest)) == {}
