"""A shape from outside collides, is certified, drawn, written and read as the others are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import fcl
import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.dynamics import (
    Body,
    Force,
    Model,
    Rate,
    Sphere,
    System,
    angle,
    length,
    move,
    parameter,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.language.shapes import ORIGIN, AxisName, Hull, Point, Shape
from kinolab.dynamics.language.shapes.bounding_radius import bounding_radius
from kinolab.errors import InputError
from kinolab.robots.writing.mjcf_text import mjcf_text
from kinolab.robots.writing.urdf_text import urdf_text
from kinolab.runs.folder import check_run
from kinolab.show.film.animation import animate
from kinolab.show.scene.models.paint import paint
from kinolab.verification import verify
from kinolab.world import BodyGeometry, CollisionChecker, World, box_obstacle, sphere_obstacle
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances.placed_shapes import lowest_heights
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN
from kinolab.world.shapes.geometry import lowest_z, placement, triangles
from kinolab.world.shapes.shrinking import shrunk_shape
from tests.extension.ellipsoid import Ellipsoid
from tests.javascript_engine import Engine

EGG, NEEDLE, PANCAKE = (
    Ellipsoid(0.5, 0.3, 0.2),
    Ellipsoid(1.0, 0.05, 0.08),
    Ellipsoid(0.6, 0.5, 0.03),
)
SHAPES = [EGG, NEEDLE, PANCAKE, Ellipsoid(0.2, 0.2, 0.2)]
STANDS_OUT = 0.006  # of the largest semi-axis: 0.5 % as ``Shape`` says, and rounding
WALL = box_obstacle("wall", (2.0, 20.0, 20.0), (1.0, 0.0, 0.0))  # its face is the plane x = 0


def axes_of(shape: Ellipsoid) -> np.ndarray:
    return np.array([shape.x, shape.y, shape.z], dtype=float)


def poses_of(count: int, seed: int = 0) -> np.ndarray:
    """Random rotations, at the origin; (count, 3, 4)."""
    turns = Rotation.random(count, random_state=seed).as_matrix()
    return np.concatenate([turns, np.zeros((count, 3, 1))], axis=2)


def beyond(shape: Ellipsoid, points: np.ndarray) -> np.ndarray:
    """Bound how far points (n, 3) outside stand out, by the way to them along the ray; in [m]."""
    size = np.linalg.norm((points - np.array(shape.at)) / axes_of(shape), axis=1)
    return np.linalg.norm(points - np.array(shape.at), axis=1) * (1.0 - 1.0 / size)


def reach(shape: Ellipsoid, pose: np.ndarray) -> float:
    """The support function along x of a turned ellipsoid."""
    return float(np.linalg.norm(axes_of(shape) * pose[0, :3]))


def distance_to(shape: Ellipsoid, point: np.ndarray) -> float:
    """The distance of a point outside, in the ellipsoid's frame; minus infinity inside.

    The nearest point has x_i = a_i^2 p_i / (a_i^2 + t), with t > 0 such that it is on the surface.
    Source: Eberly, Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid, 2013.
    """
    squares = axes_of(shape) ** 2

    def surplus(t: float) -> float:
        return float((squares * point**2 / (squares + t) ** 2).sum() - 1.0)

    if surplus(0.0) <= 0.0:
        return -math.inf
    t = brentq(surplus, 0.0, 2.0 * math.sqrt(squares.max()) * np.linalg.norm(point), xtol=1e-14)
    return float(np.linalg.norm(point - squares * point / (squares + t)))


@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_drawn_and_touched_holds_the_ellipsoid_and_hardly_more(shape: Ellipsoid) -> None:
    """Planes of its faces leave the ellipsoid behind: n . p >= |D n| for all of them."""
    vertices, faces = triangles(shape)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    offsets = np.einsum("ij,ij->i", n, a)
    assert (offsets >= np.linalg.norm(axes_of(shape) * n, axis=1) * (1.0 - 1e-9)).all()
    least = np.linalg.norm(axes_of(shape) * n, axis=1)
    assert (offsets - least).max() < STANDS_OUT * axes_of(shape).max()
    assert trimesh.Trimesh(vertices, faces, process=False).is_watertight
    drawn = paint(shape, (1.0, 0.0, 0.0))
    np.testing.assert_allclose(np.ptp(drawn.vertices, axis=0), 2 * axes_of(shape), rtol=0.01)


@pytest.mark.parametrize("shape", SHAPES)
def test_clearance_of_a_wall_is_the_closed_form(shape: Ellipsoid) -> None:
    """A wall at the distance d leaves d - |D R^T n|."""
    body = BodyGeometry("egg", (shape,))
    checker = CollisionChecker([body], World((WALL,)))
    bound = ClearanceBound(collision_scene([body], World((WALL,))))
    for pose in poses_of(40):
        for gap in (0.01, 0.3):
            pose[0, 3] = -reach(shape, pose) - gap
            found = checker.clearance(pose.reshape(1, 12))
            assert gap - STANDS_OUT * axes_of(shape).max() < found < gap + 1e-9
            proved = bound.within(pose.reshape(1, 12), np.zeros((0, 6)), 1.0)
            assert found - 2 * TOUCHING_MARGIN < proved <= found
        pose[0, 3] = -reach(shape, pose) + 1e-4
        assert checker.collides(pose.reshape(1, 12))


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("mesh", [False, True])
def test_fcl_with_an_ellipsoid_of_its_own_finds_the_same_contacts(
    shape: Ellipsoid, mesh: bool
) -> None:
    """And both touch where the closed form says so; FCL's own distances err by millimetres."""
    ball = sphere_obstacle("ball", 0.4)
    if mesh:
        ball = replace(ball, primitive=None)
    body = BodyGeometry("egg", (shape,))
    checker = CollisionChecker([body], World((ball,)))
    theirs = fcl.CollisionObject(fcl.Ellipsoid(*axes_of(shape)))
    fixed = fcl.CollisionObject(fcl.Sphere(0.4))
    random, met = np.random.default_rng(3), 0
    for pose in poses_of(300, seed=2):
        away = random.normal(size=3)
        pose[:, 3] = random.uniform(0.3, 1.5) * away / np.linalg.norm(away)
        theirs.setRotation(pose[:, :3])
        theirs.setTranslation(pose[:, 3])
        gap = distance_to(shape, -pose[:, :3].T @ pose[:, 3]) - 0.4
        collides = checker.collides(pose.reshape(1, 12))
        slack = 1e-3 + 0.01 * axes_of(shape).max()  # of the drawn ball, and of the hull
        assert collides or gap > -slack
        assert not collides or gap < slack
        if not mesh and gap > slack:
            assert gap - slack < checker.clearance(pose.reshape(1, 12)) < gap + 1e-9
        if abs(gap) > 1e-3:
            request = fcl.CollisionRequest(), fcl.CollisionResult()
            assert bool(fcl.collide(theirs, fixed, *request)) == (gap < 0.0)
        met += collides
    assert 30 < met < 270


def test_a_slimmer_one_lies_inside_as_deep_as_was_asked_for() -> None:
    slim = triangles(shrunk_shape(EGG, 0.05))[0]
    rays = Rotation.random(200, random_state=1).as_matrix()[:, 0]
    reach = np.linalg.norm(axes_of(EGG) * rays, axis=1)
    assert (reach - (slim @ rays.T).max(axis=0)).min() >= 0.049  # [m]


def test_depth_and_bounding_radius_are_those_of_the_ellipsoid() -> None:
    assert EGG.depths(np.zeros(3)) == pytest.approx(0.2, abs=STANDS_OUT * 0.5)
    assert float(bounding_radius(EGG).radius) == pytest.approx(0.5, rel=STANDS_OUT)
    assert float(bounding_radius(replace(EGG, at=(0.0, 3.0, 4.0))).radius) > 5.5


def rolling_egg(shape: Shape = EGG) -> System:
    """An egg on a wheel below it, which rolls without sideslip."""
    x, y, heading = length("x"), length("y"), angle("heading")
    frame = move(x, y, 0.5) @ rot_z(heading)
    rolling = velocity(frame)
    return System(
        "egg",
        bodies=[Body("egg", frame, shape=shape)],
        constraints=[zero(rolling.y, "no sideslip")],
        inputs=[Rate("v", on=rolling.x, limit=1.0), Rate("w", on=heading, limit=2.0)],
    )


@pytest.fixture(scope="module")
def plan() -> Any:
    problem = kinolab.load(
        {
            "system": rolling_egg(),
            "world": {
                "bounds": {"x": [-3, 3], "y": [-3, 3]},
                "obstacle": [{"name": "block", "box": [0.5, 2.0, 1.0], "position": [0, 0, 0.5]}],
            },
            "start": {"x": -2.0},
            "goal": {"x": 2.0, "y": 0.0, "tolerance": 0.3},
            "planner": {"name": "rrt", "improve": 0},
        }
    )
    return problem.solve(seed=1, time_limit=60.0)


def test_a_plan_leads_round_an_obstacle_and_is_certified(plan: Any) -> None:
    """Points of the ellipsoid stay out of the block between the samples, too."""
    assert plan.trajectory is not None
    certificate = verify(plan.problem, plan.trajectory)
    assert certificate.passed
    rays = Rotation.random(400, random_state=1).as_matrix()[:, 0]
    points, x = EGG.support(rays), plan.trajectory.x
    closest = math.inf
    for pose in plan.problem.model.frames(x).reshape(len(x), 3, 4):
        placed = points @ pose[:, :3].T + pose[:, 3]
        out = np.maximum(np.abs(placed - [0.0, 0.0, 0.5]) - [0.25, 1.0, 0.5], 0.0)
        closest = min(closest, float(np.linalg.norm(out, axis=1).min()))
    assert closest > 0.0


def test_its_run_is_checked_by_its_files_alone(
    plan: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the class says now, and whether there is one."""
    folder = plan.save(tmp_path / "run")
    monkeypatch.setattr(Ellipsoid, "support", None)
    assert check_run(folder).passed
    (shape,) = kinolab.read_run(folder).problem.bodies[0].shapes
    assert isinstance(shape, Hull)


def test_film_page_and_model_file_draw_it(plan: Any, tmp_path: Path) -> None:
    kinolab.save_glb(plan.problem, plan, tmp_path / "egg.glb")
    scene = trimesh.load(tmp_path / "egg.glb")
    sizes = [np.sort(mesh.extents) for mesh in scene.geometry.values()]
    assert any(np.allclose(size, [0.4, 0.6, 1.0], rtol=0.01) for size in sizes)
    kinolab.save_page(plan.problem, plan, tmp_path / "egg.html")
    assert "egg" in (tmp_path / "egg.html").read_text()
    assert animate(plan.problem, plan.trajectory).startswith(b"GIF8")


def test_the_page_knows_its_surface() -> None:
    model = rolling_egg(replace(EGG, at=(0.1, 0.0, 0.0))).model()
    with Engine() as engine:
        ((egg,),) = engine.run(f"return {engine.machine(model)}.shapes()")
    assert egg["kind"] == "hull"
    corners = np.array(egg["size"]["corners"])
    np.testing.assert_allclose(np.ptp(corners, axis=0), 2 * axes_of(EGG), rtol=0.01)
    assert egg["at"] == [0.1, 0.0, 0.0]


def test_a_machine_file_has_its_points_so_that_reading_it_needs_no_class() -> None:
    """They hold the ellipsoid, and stand out by 0.5 % of its size at most."""
    text = machine_to_json(rolling_egg())
    back = machine_from_json(text)
    (hull,) = back.bodies[0].shapes
    assert (type(hull), hull.called) == (Hull, "Ellipsoid")
    assert machine_to_json(back) == text
    rays = Rotation.random(400, random_state=1).as_matrix()[:, 0]
    out = (triangles(hull)[0] @ rays.T).max(axis=0) - np.linalg.norm(axes_of(EGG) * rays, axis=1)
    assert out.min() > -1e-12
    assert out.max() < STANDS_OUT * 0.5
    assert Model(back).key == rolling_egg().model().key


@dataclass(frozen=True)
class Fuller(Ellipsoid):
    """What the ellipsoid's module may say tomorrow."""

    def support(self, directions: np.ndarray) -> np.ndarray:
        return 1.2 * super().support(directions)


Fuller.__name__ = "Ellipsoid"


def test_a_machine_is_compiled_anew_where_the_code_of_its_shape_has_changed() -> None:
    """Bounds on speeds are compiled, so that old ones would prove too much."""
    egg, fuller = (rolling_egg(kind(0.5, 0.3, 0.2)) for kind in (Ellipsoid, Fuller))
    assert egg.model().key != fuller.model().key


@pytest.mark.parametrize("kind", [Ellipsoid, Fuller])
def test_each_of_two_classes_of_one_name_is_read_as_itself(kind: type[Ellipsoid]) -> None:
    egg = kind(0.5, 0.3, 0.2)
    (hull,) = machine_from_json(machine_to_json(rolling_egg(egg))).bodies[0].shapes
    assert hull.called == "Ellipsoid"
    reach = egg.support(np.array([[1.0, 0.0, 0.0]]))[0, 0]
    assert triangles(hull)[0].max() == pytest.approx(reach, rel=STANDS_OUT)


@pytest.mark.parametrize("name", ["Sphere", "Box", "Hull"])
def test_a_shape_with_the_name_of_one_of_kinolabs_is_refused(name: str) -> None:
    with pytest.raises(InputError) as caught:
        type(name, (Ellipsoid,), {})
    said = f"class {name}: kinolab has a word of this name. Choose another name."
    assert str(caught.value) == said


@dataclass(frozen=True)
class Marble(Sphere):
    """A class below one of kinolab's shapes is still from outside."""


def test_a_class_below_a_ball_is_kept_as_points() -> None:
    (hull,) = machine_from_json(machine_to_json(rolling_egg(Marble(0.3)))).bodies[0].shapes
    vertices = triangles(hull)[0]
    assert np.linalg.norm(vertices, axis=1).min() > 0.3 * (1 - 1e-12)
    assert np.linalg.norm(vertices, axis=1).max() < 0.3 * (1 + STANDS_OUT)


def test_a_hull_is_that_of_the_parameters_it_was_made_for() -> None:
    """Its place follows a parameter, its points do not."""
    r, far = parameter("r", 0.3, "m"), parameter("far", 1.0, "m")
    egg = Ellipsoid.__new__(Ellipsoid)
    for name, value in {"x": r, "y": 0.2, "z": 0.1, "at": (far, 0, 0)}.items():
        object.__setattr__(egg, name, value)
    back = machine_from_json(machine_to_json(rolling_egg(egg).with_parameters(r=0.5)))
    assert triangles(back.resolved_shapes(back.bodies[0])[0])[0].max() == pytest.approx(1.5, 0.01)
    assert back.with_parameters(far=2.0).parameter_values["far"] == 2.0
    with pytest.raises(InputError, match=r"it was made for r = 0\.5, and r is 0\.3"):
        back.with_parameters(r=0.3)


def sliding_egg() -> System:
    x, y = length("x"), length("y")
    body = Body("egg", move(x, y), mass=2.0, inertia=0.1, shape=replace(EGG, at=(0.1, 0.2, 0.3)))
    inputs = [Force("push", on=body, along=body.frame.x, limit=1.0)]
    return System("slider", bodies=[body], inputs=inputs)


def test_mujoco_reads_a_hull_of_the_same_place_and_size() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf_text(sliding_egg()))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    turn, at = data.geom_xmat[0].reshape(3, 3), data.geom_xpos[0]
    vertices = model.mesh_vert @ turn.T + at
    np.testing.assert_allclose(vertices.max(axis=0), [0.6, 0.5, 0.5], atol=STANDS_OUT)
    np.testing.assert_allclose(vertices.min(axis=0), [-0.4, -0.1, 0.1], atol=STANDS_OUT)


def test_urdf_which_has_no_such_shape_says_so() -> None:
    with pytest.raises(InputError, match="URDF has no shape Ellipsoid"):
        urdf_text(sliding_egg())
    assert "<geometry>" not in urdf_text(sliding_egg(), partial=True)


@dataclass(frozen=True)
class Cone(Shape):
    """A cone about z, which looks different from above and from below; its centre is in it."""

    radius: float
    height: float
    axis: AxisName = "z"
    at: Point = ORIGIN

    symmetric = "z"

    def support(self, directions: np.ndarray) -> np.ndarray:
        across = np.linalg.norm(directions[:, :2], axis=1, keepdims=True)
        rim = self.radius * directions[:, :2] / np.where(across > 0.0, across, 1.0)
        rim = np.column_stack([rim, np.full(len(rim), -0.25 * self.height)])
        tip = np.array([0.0, 0.0, 0.75 * self.height])
        higher = directions @ tip > np.einsum("ij,ij->i", directions, rim)
        return np.where(higher[:, None], tip, rim)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_what_looks_different_from_both_sides_is_as_far_from_both(axis: AxisName) -> None:
    """Closed forms: its corners are a tip and a circle."""
    cone = Cone(0.4, 1.0, axis)
    body, slack = BodyGeometry("cone", (cone,)), STANDS_OUT * 0.75
    for side in (1.0, -1.0):
        wall = box_obstacle("wall", (2.0, 20.0, 20.0), (side, 0.0, 0.0))
        checker = CollisionChecker([body], World((wall,)))
        bound = ClearanceBound(collision_scene([body], World((wall,))))
        for pose in poses_of(40):
            toward = pose[0, :3] @ placement(cone)[:, :3] * side
            farthest = float(toward @ cone.support(toward[None])[0])
            pose[0, 3] = -side * (farthest + 0.1)
            found = checker.clearance(pose.reshape(1, 12))
            assert 0.1 - slack < found < 0.1 + 1e-9
            proved = bound.within(pose.reshape(1, 12), np.zeros((0, 6)), 1.0)
            assert found - 2 * TOUCHING_MARGIN < proved <= found
            down = -pose[2, :3] @ placement(cone)[:, :3]
            lowest = -float(down @ cone.support(down[None])[0])
            assert lowest - slack < lowest_z(cone, pose) < lowest + 1e-9
            assert lowest_heights(cone, pose[None])[0] == pytest.approx(lowest_z(cone, pose))


@dataclass(frozen=True)
class Sheet(Shape):
    """A square without thickness."""

    edge: float
    at: Point = ORIGIN

    def support(self, directions: np.ndarray) -> np.ndarray:
        return np.sign(directions) * [self.edge, self.edge, 0.0]


def test_a_solid_without_thickness_is_refused() -> None:
    with pytest.raises(InputError, match="shape Sheet: no hull around it can be made: it is flat"):
        Sheet(1.0).lowered()
