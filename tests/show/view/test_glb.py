"""``result.glb`` as two other programs read it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.analyze.simulate import simulate
from kinolab.loading import build_problem, find_scenario
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory

NEAR = 1e-6  # of frames at keys, for scenes of a few metres: single precision


def moved(trajectory: Trajectory) -> PlanResult:
    return PlanResult("simulated", trajectory, None, "none", 0, 0, 0.0)


@pytest.fixture(scope="module")
def crane(tmp_path_factory: pytest.TempPathFactory) -> tuple[PlanningTask, Trajectory, Path]:
    """A swinging crane of bodies and one cable, in a world with a box."""
    scenario = find_scenario("crane", overrides=["start.theta_x=0.5", "start.theta_y=-0.2"])
    problem = build_problem(scenario, planning=False)
    trajectory = simulate(problem, 1.0)
    path = tmp_path_factory.mktemp("glb") / "result.glb"
    kinolab.save_glb(problem, moved(trajectory), path)
    return problem, trajectory, path


def animated(path: Path) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Keys and values of every channel, by the node's name and what is animated."""
    pygltflib = pytest.importorskip("pygltflib")
    file = pygltflib.GLTF2().load(str(path))
    (animation,) = file.animations
    found = {}
    for channel in animation.channels:
        sampler = animation.samplers[channel.sampler]
        assert sampler.interpolation == "LINEAR"
        name = file.nodes[channel.target.node].name
        times, values = (numbers(file, i) for i in (sampler.input, sampler.output))
        found[name, channel.target.path] = times[:, 0], values
    return found


def numbers(file: Any, index: int) -> np.ndarray:
    pygltflib = pytest.importorskip("pygltflib")
    accessor = file.accessors[index]
    view = file.bufferViews[accessor.bufferView]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
    assert accessor.componentType == pygltflib.FLOAT
    data = file.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    return np.frombuffer(data, "<f4").reshape(accessor.count, width)


def test_the_nodes_of_bodies_have_their_frames_at_every_knot(
    crane: tuple[PlanningTask, Trajectory, Path],
) -> None:
    problem, trajectory, path = crane
    channels = animated(path)
    g = problem.model.frames(trajectory.x).reshape(len(trajectory.t), -1, 3, 4)
    for b, body in enumerate(problem.bodies):
        for what in ("translation", "rotation"):
            times, values = channels[body.name, what]
            rows = np.searchsorted(times, trajectory.t.astype(np.float32))
            assert times[rows] == pytest.approx(trajectory.t, abs=1e-6)
            if what == "translation":
                assert values[rows] == pytest.approx(g[:, b, :, 3], abs=NEAR)
            else:
                R = Rotation.from_quat(values[rows]).as_matrix()
                assert pytest.approx(g[:, b, :, :3], abs=NEAR) == R


def test_a_cable_is_a_rod_between_its_ends(crane: tuple[PlanningTask, Trajectory, Path]) -> None:
    problem, trajectory, path = crane
    channels, ends = animated(path), problem.model.cables(trajectory.x)[:, 0]
    place, turn, scale = (
        channels["cable 1", what][1] for what in ("translation", "rotation", "scale")
    )
    times = channels["cable 1", "translation"][0]
    rows = np.searchsorted(times, trajectory.t.astype(np.float32))
    tip = Rotation.from_quat(turn).apply(np.array([0.0, 0.0, 1.0])) * scale[:, 2:]
    assert place[rows] == pytest.approx(ends[:, 0], abs=NEAR)
    assert (place + tip)[rows] == pytest.approx(ends[:, 1], abs=5 * NEAR)


def test_another_program_finds_the_world_where_it_is(tmp_path: Path) -> None:
    """kinolab's up, z, is the file's y."""
    problem = kinolab.load("rolling_disk_maze")
    plan = moved(simulate(problem, 0.2))
    path = kinolab.save_glb(problem, plan, tmp_path / "maze.glb")
    scene = trimesh.load(io.BytesIO(path.read_bytes()), file_type="glb")
    assert problem.world.obstacles
    for obstacle in problem.world.obstacles:
        transform, geometry = scene.graph[obstacle.name]
        mesh = scene.geometry[geometry]
        points = trimesh.transform_points(mesh.vertices, transform)
        low, high = obstacle.vertices.min(axis=0), obstacle.vertices.max(axis=0)
        assert points.min(axis=0) == pytest.approx([low[0], low[2], -high[1]], abs=1e-5)
        assert points.max(axis=0) == pytest.approx([high[0], high[2], -low[1]], abs=1e-5)
    assert {"coin", "floor", "path", "start", "goal"} <= set(scene.graph.nodes)


def test_a_machine_whose_up_is_another_axis_stands_upright(tmp_path: Path) -> None:
    """The pendulum's x points down: hanging at rest, its bob is at y = -l."""
    pygltflib = pytest.importorskip("pygltflib")
    problem = build_problem(find_scenario("pendulum"), planning=False)
    path = kinolab.save_glb(problem, moved(simulate(problem, 0.1)), tmp_path / "p.glb")
    file = pygltflib.GLTF2().load(str(path))
    root = Rotation.from_quat(file.nodes[0].rotation)
    assert problem.system.gravity is not None
    assert root.apply(problem.system.gravity.down) == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)


def test_rotors_turn_in_steps_that_a_viewer_can_follow(tmp_path: Path) -> None:
    """Less than half a turn between two keys, or it would turn back."""
    problem = build_problem(find_scenario("helicopter"), planning=False)
    path = kinolab.save_glb(problem, moved(simulate(problem, 0.5)), tmp_path / "h.glb")
    times, values = animated(path)["main rotor shape", "rotation"]
    (whirl,) = {body.whirl for body in problem.bodies if body.name == "main rotor"}
    turns = Rotation.from_quat(values)
    steps = (turns[:-1].inv() * turns[1:]).as_rotvec()[:, 2]
    assert np.abs(steps).max() < np.pi / 2
    assert steps / np.diff(times) == pytest.approx(whirl, rel=1e-4)
