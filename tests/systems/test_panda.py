"""The arm against Pinocchio, which reads the robot description of others."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.language.json.machine_file import files_of, load_machine
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Shape
from kinolab.numerics.arrays import Array

pinocchio = pytest.importorskip("pinocchio")
ROBOTS = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data")
PANDA = next(ROBOTS, Path("not installed")) / "robots" / "panda_description"
pytestmark = pytest.mark.skipif(not PANDA.is_dir(), reason="needs example-robot-data")

PAYLOAD, FINGER = 1.0, 0.015  # [kg]
RADIUS, HEIGHT, GRIP = 0.033, 0.12, 0.1034  # [m] of the can, and where it is held
ROOM = 0.006  # [m] by which the robot's surface may stand out of the shapes


@pytest.fixture(scope="module")
def theirs() -> tuple[object, object]:
    """The seven joints with hand and can; fingers, which the machine has not, without mass."""
    whole = pinocchio.buildModelFromUrdf(str(PANDA / "urdf" / "panda.urdf"))
    reduced = pinocchio.buildReducedModel(whole, [8, 9], pinocchio.neutral(whole))
    last = reduced.joints[7].id
    hand = reduced.frames[reduced.getFrameId("panda_hand")].placement
    out = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, 0.0584]))
    finger = pinocchio.Inertia(FINGER, np.zeros(3), np.diag([2.375e-6, 2.375e-6, 7.5e-7]))
    for _ in range(2):
        reduced.inertias[last] -= (hand * out).act(finger)
    pitch = pinocchio.SE3(pinocchio.utils.rotate("y", np.pi / 4), np.array([0.0, 0.0, GRIP]))
    along, across = RADIUS**2 / 2, (3 * RADIUS**2 + HEIGHT**2) / 12
    can = pinocchio.Inertia(PAYLOAD, np.zeros(3), PAYLOAD * np.diag([along, across, across]))
    reduced.inertias[last] += (hand * pitch).act(can)
    return reduced, reduced.createData()


def test_accelerations_under_torques_are_pinocchio_s(theirs) -> None:  # type: ignore[no-untyped-def]
    model, data = theirs
    own = systems.get("panda").with_feedback(None).model()
    generator = np.random.default_rng(0)
    for _ in range(20):
        x = generator.uniform(*own.state_bounds.T)
        u = generator.uniform(*own.control_bounds.T)
        expected = pinocchio.aba(model, data, x[:7], x[7:], u)
        assert np.abs(own.f(x, u)[7:] - expected).max() <= 1e-9 * np.abs(expected).max()


def test_set_points_are_taken_on_at_one_rate_in_every_pose() -> None:
    """From rest joints accelerate by the quickness, and the arm hangs still without set points."""
    own = systems.get("panda").model()
    generator = np.random.default_rng(1)
    for _ in range(20):
        x = own.rest()
        x[:7] = generator.uniform(*own.state_bounds[:7].T)
        assert np.abs(own.f(x, np.zeros(7))[7:]).max() < 1e-9
        wanted = 0.01 * generator.uniform(-1, 1, 7)
        assert own.f(x, wanted)[7:] == pytest.approx(10.0 * wanted, abs=1e-9)


def test_the_can_is_upright_where_the_hand_points_down_by_45_degrees() -> None:
    own = systems.get("panda").model()
    x = own.rest()
    x[[1, 3, 5, 6]] = -0.02691408648003177, -2.4493370997825745, 3.207821176701008, np.pi / 4
    names = [body.name for body in own.machine.bodies]
    can = own.frames(x)[names.index("can")].reshape(3, 4)
    hand = own.frames(x)[names.index("hand")].reshape(3, 4)
    assert can[:, 0] == pytest.approx([0, 0, 1], abs=1e-6)
    assert hand[:, 2] == pytest.approx(np.array([1, 0, -1]) / np.sqrt(2), abs=1e-6)
    assert can[:, 3] == pytest.approx([0.6, 0.0, 0.33], abs=1e-6)


def beyond(shape: Shape, points: Array) -> Array:
    """Return how far points of a body's frame (n, 3) are outside a shape, in [m]."""
    q = points - np.array(shape.at, dtype=float)
    if isinstance(shape, Box):
        return (np.abs(q) - np.array([shape.x, shape.y, shape.z], dtype=float) / 2).max(axis=1)
    assert isinstance(shape, Capsule | Cylinder)
    axis, half, radius = "xyz".index(shape.axis), float(shape.length) / 2, float(shape.radius)
    if isinstance(shape, Capsule):
        q[:, axis] -= np.clip(q[:, axis], -half, half)
        return np.linalg.norm(q, axis=1) - radius
    across = np.linalg.norm(np.delete(q, axis, axis=1), axis=1)
    return np.maximum(across - radius, np.abs(q[:, axis]) - half)


def test_the_shapes_hold_the_robot_s_own_meshes() -> None:
    own = systems.get("panda").model()
    names = [body.name for body in own.machine.bodies]
    generator = np.random.default_rng(2)
    for _ in range(5):
        x = own.rest()
        x[:7] = generator.uniform(*own.state_bounds[:7].T)
        poses = own.frames(x).reshape(-1, 3, 4)
        for name, file in [*((f"link {k}", f"link{k}") for k in range(1, 8)), ("hand", "hand")]:
            mesh = trimesh.load(PANDA / "meshes" / "collision" / f"{file}.stl")
            place = poses[names.index(name)]
            points = np.asarray(mesh.vertices) @ place[:, :3].T + place[:, 3]
            out = [
                beyond(shape, (points - pose[:, 3]) @ pose[:, :3])
                for body, pose in zip(own.machine.bodies, poses, strict=True)
                for shape in body.shapes
            ]
            assert np.min(out, axis=0).max() <= ROOM


def test_its_law_is_written_once_and_read_again(tmp_path: Path) -> None:
    """Written out, it would have a million terms."""
    own = systems.get("panda")
    for name, text in files_of(own).items():
        assert len(text) < 500_000
        (tmp_path / name).write_text(text)
    again, generator = Model(load_machine(tmp_path / "machine.json")), np.random.default_rng(3)
    model = own.model()
    for _ in range(5):
        x = generator.uniform(*model.state_bounds.T)
        u = generator.uniform(*model.control_bounds.T)
        expected = model.plant_inputs(x, u)
        assert again.plant_inputs(x, u) == pytest.approx(expected, rel=1e-9, abs=1e-9)
