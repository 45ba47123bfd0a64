"""The camera sees the machine: directions, translucent walls, rooms that are cut open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Box, Sphere
from kinolab.show.film.staging.stage import build_stage
from kinolab.show.page.follow import follow_track
from kinolab.show.scene.camera import Angles, Camera, frame_scene
from kinolab.show.scene.models.cut import along, cut_open, level
from kinolab.show.scene.models.surface_mesh import areas_of, is_room, weld
from kinolab.show.scene.picture import Picture, Surface
from kinolab.show.scene.sight import SEEN, Screens
from tests.show.film.films import box_surface

SIZE = (400, 300)
BALL = [BodyGeometry("ball", (Sphere(0.1),))]
BOUNDS = {"x": (-3.0, 3.0), "y": (-3.0, 3.0)}


def way(*points: tuple[float, float, float]) -> np.ndarray:
    """Poses of a ball at some points, shape (n, 1, 12)."""
    eye = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    poses = np.concatenate([eye, np.array(points)[:, :, None]], axis=2)
    return np.asarray(poses.reshape(-1, 1, 12))


def room_of(box: Surface) -> Surface:
    return Surface(box.name, box.vertices, box.faces[:, ::-1].copy())


def test_a_face_hides_what_is_behind_it_and_only_that() -> None:
    """A square of edge 2 at depth 5; rays to depth 10 meet it within 1 of the axis, so 2 behind."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    camera = Camera(np.array([0, 0, 5.0]), np.zeros(3), np.array([0, 1.0, 0]), 1.0)
    points = np.array([[1.9, 0.3, -5], [2.1, 0.3, -5], [0, 0.3, 1.0], [-1.9, -1.9, -5]])
    both = Screens(corners, faces, np.zeros(2, dtype=bool)).hiding(camera, points)
    assert (both == SEEN).tolist() == [False, True, True, False]
    behind = Screens(corners, faces[:, ::-1], np.ones(2, dtype=bool)).hiding(camera, points)
    assert (behind == SEEN).all()  # seen from behind, a room's wall is not there


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_wall_is_looked_at_from_the_side_on_which_the_machine_goes(side: float) -> None:
    """The wall is higher than wide is the space behind it, so that no elevation looks over it."""
    wall = box_surface("wall", (6.0, 0.1, 4.0), (0.0, -0.5 * side, 2.0))
    motion = way(*((x, 0.0, 0.1) for x in np.linspace(-2, 2, 9)))
    picture = Picture(bodies=BALL, obstacles=[wall], ground=True, bounds=BOUNDS)
    still = build_stage(picture, motion, SIZE).still
    toward = np.cos(still.outlook.angles.azimuth)  # of the camera along -y
    assert toward * side < 0.0 or side < 0.0
    assert still.outlook.seen > 0.9
    assert not still.outlook.veiled[0].any()


def with_wall(motion: np.ndarray, moves: tuple[float, float]) -> tuple[Picture, np.ndarray]:
    """Return the picture of a ball and a wall of 6 m that moves evenly by (x, y) meanwhile."""
    wall = BodyGeometry("wall", (Box(6.0, 0.1, 4.0),), prescribed=True)
    steps = np.linspace(0.0, 1.0, len(motion))
    places = way(*((moves[0] * s, -0.5 + moves[1] * s, 2.0) for s in steps))
    picture = Picture(bodies=[*BALL, wall], ground=True, bounds=BOUNDS)
    return picture, np.concatenate([motion, places], axis=1)


def test_an_obstacle_that_moves_hides_what_is_behind_it_at_each_time() -> None:
    """It stands in front of the way as long as the machine goes there, or has gone before."""
    motion = way(*((x, 0.0, 0.1) for x in np.linspace(-2, 2, 9)))
    picture, both = with_wall(motion, (0.1, 0.0))
    still = build_stage(picture, both, SIZE).still
    assert np.cos(still.outlook.angles.azimuth) < 0.0  # from behind, as past a wall that stands
    assert still.outlook.seen > 0.9
    fixed = replace(picture, azimuth=0.0, elevation=0.1)
    assert build_stage(fixed, both, SIZE).still.outlook.seen < 0.1
    gone, away = with_wall(motion, (50.0, 0.0))
    seen = build_stage(replace(gone, azimuth=0.0, elevation=0.1), away, SIZE).still.outlook.seen
    assert 0.5 < seen < 1.0


def test_the_whole_way_of_an_obstacle_that_moves_is_in_the_picture() -> None:
    """It leaves the world's bounds by 4 m, and stays below the title."""
    picture, both = with_wall(way(*((x, 0.0, 0.1) for x in np.linspace(-2, 2, 9))), (0.0, 7.5))
    pen = build_stage(picture, both, SIZE).pen
    corners = np.array([[x, y, 2.0 + z] for x in (-3, 3) for y in (6.95, 7.05) for z in (-2, 2)])
    places = pen.camera.project(corners, SIZE)[:, :2]
    assert (places >= (0.0, 0.05 * SIZE[1])).all()
    assert (places <= SIZE).all()


def test_what_a_scenario_says_about_its_camera_is_kept() -> None:
    picture = Picture(bodies=BALL, ground=True, bounds=BOUNDS, azimuth=0.5 * np.pi, elevation=0.3)
    camera = build_stage(picture, way((0.0, 0.0, 0.1)), SIZE).pen.camera
    look = camera.position - camera.target
    look /= np.linalg.norm(look)
    assert look == pytest.approx([np.cos(0.3), 0.0, np.sin(0.3)], abs=1e-9)


def test_a_lid_over_everything_becomes_translucent_as_a_whole() -> None:
    lid = box_surface("lid", (6.0, 6.0, 0.1), (0.0, 0.0, 1.0))
    sides = [box_surface(f"{k}", (0.1, 6.0, 1.0), (x, 0.0, 0.5)) for k, x in enumerate((-3, 3))]
    ends = [box_surface(f"{k}", (6.0, 0.1, 1.0), (0.0, y, 0.5)) for k, y in enumerate((-3, 3))]
    picture = Picture(bodies=BALL, obstacles=[lid, *sides, *ends], ground=True, bounds=BOUNDS)
    motion = way(*((x, 0.3 * x, 0.1) for x in np.linspace(-2, 2, 9)))
    veiled = build_stage(picture, motion, SIZE).still.outlook.veiled[0]
    mesh = picture.obstacle_meshes()[0]
    upper = mesh.normals[:, 2] > 0.5
    assert veiled[upper].all()


def test_a_cut_leaves_what_is_below_and_closes_it() -> None:
    """A cube of edge 2 on the ground, cut at 0.5 m: walls of 4 x 2 x 0.5 m^2, foot and lid of 4."""
    box = box_surface("box", (2.0, 2.0, 2.0), (0.0, 0.0, 1.0))
    mesh = cut_open(weld(box.vertices, box.faces, (1.0, 0.0, 0.0)), level(0.5))
    assert mesh.vertices[:, 2].max() == pytest.approx(0.5, abs=5e-3)
    assert areas_of(mesh.vertices, mesh.faces).sum() == pytest.approx(4 * 2 * 0.5 + 4 + 4, rel=1e-3)


def test_a_room_that_is_cut_lies_in_ground_with_a_hole_as_large_as_the_room() -> None:
    """The room is 4 x 2 m; the ground reaches 6 % of 4 m beyond it on every side."""
    room = room_of(box_surface("room", (4.0, 2.0, 2.0), (0.0, 0.0, 1.0)))
    whole = weld(room.vertices, room.faces, (1.0, 0.0, 0.0))
    assert is_room(whole)
    mesh = cut_open(whole, level(1.0))
    flat = np.abs(mesh.vertices[mesh.faces][..., 2] - 1.0).max(axis=1) < 1e-9
    assert areas_of(mesh.vertices, mesh.faces)[flat].sum() == pytest.approx(
        4.48 * 2.48 - 4 * 2, rel=1e-3
    )


def test_a_cut_along_a_way_passes_through_it_and_stays_between_its_heights() -> None:
    points = np.column_stack([np.linspace(0, 9, 40), np.zeros(40), np.linspace(1.0, 4.0, 40)])
    heights = along(points)
    assert heights(points[:, :2]) == pytest.approx(points[:, 2], abs=0.05)
    somewhere = heights(np.random.default_rng(1).uniform(-5, 15, (200, 2)))
    assert (somewhere >= 1.0).all() and (somewhere <= 4.0).all()  # noqa: PT018


def test_the_camera_that_follows_goes_round_walls() -> None:
    """In a street along x between high walls one sees the machine from along the street only."""
    walls = [box_surface(f"{y}", (40.0, 0.1, 20.0), (0.0, y, 10.0)) for y in (-0.6, 0.6)]
    picture = Picture(bodies=BALL, obstacles=walls, ground=True)
    motion = way(*((x, 0.0, 0.1) for x in np.linspace(-2, 2, 9)))
    meshes = picture.obstacle_meshes()
    track = follow_track(picture, meshes, np.linspace(0.0, 4.0, 9), motion, 0.1)
    assert track[[0, -1], 0] == pytest.approx([0.0, 4.0])
    for _, azimuth, elevation in track:
        across = np.cos(azimuth) * np.cos(elevation) * 3.6 * 0.1 / np.tan(np.radians(15.0))
        assert abs(across) < 0.6
    free = follow_track(replace(picture, obstacles=()), [], np.linspace(0.0, 4.0, 9), motion, 0.1)
    assert np.ptp(free[:, 1]) == 0.0


def test_angles_are_counted_from_the_front_counterclockwise() -> None:
    cloud = np.random.default_rng(1).uniform(-1, 1, (20, 3))
    for azimuth, wanted in ((0.0, [0, -1, 0]), (0.5 * np.pi, [1, 0, 0]), (np.pi, [0, 1, 0])):
        camera = frame_scene(cloud, angles=Angles(azimuth, 0.0))
        look = camera.position - camera.target
        assert look / np.linalg.norm(look) == pytest.approx(wanted, abs=1e-9)
