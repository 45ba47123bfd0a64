"""What is seen: occlusion, shadows, markers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Box, Disk, Sphere
from kinolab.show.film.raster.light import LIGHT_JITTER
from kinolab.show.film.staging.stage import Stage, build_stage
from kinolab.show.scene.models.cone import Cone, cone_mesh
from kinolab.show.scene.picture import Ghost, GoalMarker, Picture
from kinolab.show.scene.problem_picture import picture as picture_of
from tests.show.film.films import box_surface, make_film

SIZE = (400, 300)
RED = (1.0, 0.0, 0.0)
BOUNDS = {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}


def at(x: float, y: float, z: float) -> np.ndarray:
    return np.column_stack([np.eye(3), [x, y, z]]).reshape(1, 12)


def ball(radius: float) -> list[BodyGeometry]:
    return [BodyGeometry("ball", (Sphere(radius),), color=RED)]


def shot(stage: Stage, poses: np.ndarray, lines: np.ndarray | None = None) -> np.ndarray:
    """The picture with the machine at poses, shape (nb, 12), and cables, shape (nl, 2, 3)."""
    return next(stage.shots(poses[None], None if lines is None else lines[None]))


def frame(picture: Picture, poses: np.ndarray) -> np.ndarray:
    """A film's only frame."""
    return make_film(picture, [0.0], poses[None], size=SIZE).frame(0)


def reddish(image: np.ndarray) -> np.ndarray:
    pixels = image.astype(int)
    return np.asarray(pixels[..., 0] > pixels[..., 1:].max(axis=-1) + 60)


def rays_to_ground(stage: Stage) -> np.ndarray:
    """Where the line of sight through each pixel meets z = 0, shape (h, w, 2), in [m]."""
    camera, (width, height) = stage.pen.camera, SIZE
    right, up, forward = camera.axes
    focal = 0.5 * height / np.tan(0.5 * camera.fov)
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    x, y = (column - 0.5 * width) / focal, (0.5 * height - row) / focal
    ray = forward + x[..., None] * right + y[..., None] * up
    reach = -camera.position[2] / ray[..., 2:]
    return np.asarray((camera.position + reach * ray)[..., :2])


@pytest.mark.parametrize("height", [0.3, 1.5])
def test_only_the_body_and_the_ground_in_its_shadow_change(height: float) -> None:
    """A ball's shadow is an ellipse about the foot of the ray through its centre.

    Its half axes are r and r / sin(elevation of the light); half the lamp's width times the length
    of the ray, and two pixels of about 2 cm, come on top.
    """
    radius, pose = 0.3, at(0.4, -0.3, height)
    stage = build_stage(Picture(bodies=ball(radius), ground=True, bounds=BOUNDS), pose[None], SIZE)
    changed = (shot(stage, pose) != stage.image).any(axis=-1)
    centre = stage.pen.camera.project(pose.reshape(3, 4)[:, 3], SIZE)
    focal = 0.5 * SIZE[1] / np.tan(0.5 * stage.pen.camera.fov)
    column, row = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    body = np.hypot(column - centre[0], row - centre[1]) < 1.1 * focal * radius / centre[2] + 2.0

    light = stage.pen.light
    foot = pose.reshape(3, 4)[:2, 3] - height / light[2] * light[:2]
    away = np.linalg.norm(rays_to_ground(stage) - foot, axis=-1)
    blur = 2.0 * LIGHT_JITTER * (height + radius) / light[2] ** 2
    assert not (changed & ~body & (away > radius / light[2] + blur + 0.05)).any()
    assert (changed | body)[away < radius - blur - 0.05].all()


def test_the_shadow_is_darker_than_the_floor() -> None:
    pose = at(0.0, 0.0, 1.5)
    stage = build_stage(Picture(bodies=ball(0.3), ground=True, bounds=BOUNDS), pose[None], SIZE)
    foot = -1.5 / stage.pen.light[2] * stage.pen.light
    column, row = stage.pen.camera.project([foot[0], foot[1], 0.0], SIZE)[:2].astype(int)
    before, after = stage.image[row, column], shot(stage, pose)[row, column]
    assert (after < 0.9 * before).all()


def redness(image: np.ndarray) -> int:
    """How much redder than grey the reddest pixel is."""
    pixels = image.astype(int)
    return int((pixels[..., 0] - pixels[..., 1:].max(axis=-1)).max())


def test_a_wall_before_the_whole_way_is_translucent() -> None:
    wall = box_surface("wall", (4.0, 0.1, 1.0), (0.0, 0.0, 0.5))
    picture = Picture(bodies=ball(0.2), obstacles=[wall], ground=True, bounds=BOUNDS, view="front")
    behind, before = (build_stage(picture, at(0.0, y, 0.2)[None], SIZE) for y in (1.0, -1.0))
    assert reddish(shot(behind, at(0.0, 1.0, 0.2))).any()
    column, row = before.pen.camera.project([1.0, -0.05, 0.5], SIZE)[:2].astype(int)
    assert behind.image[row, column].mean() > before.image[row, column].mean() + 10


def test_behind_a_wall_before_a_part_of_the_way_the_machine_shows_through_paler() -> None:
    post = box_surface("post", (0.8, 0.1, 1.0), (1.6, 0.0, 0.5))
    picture = Picture(bodies=ball(0.2), obstacles=[post], ground=True, bounds=BOUNDS, view="front")
    way = np.stack([at(x, 1.0, 0.3) for x in np.linspace(-1.8, 1.6, 30)])
    stage = build_stage(picture, way, SIZE)
    assert not stage.still.outlook.veiled[0].any()
    hidden, seen = redness(shot(stage, way[-1])), redness(shot(stage, way[0]))
    assert redness(stage.image) + 30 < hidden < seen - 30


def test_a_machine_that_nothing_hides_does_not_shine_through_the_edge_of_a_wall() -> None:
    """Half of the ball is behind a low kerb: that is how one sees what is nearer."""
    kerb = box_surface("kerb", (4.0, 0.1, 0.2), (0.0, -0.4, 0.1))
    picture = Picture(bodies=ball(0.2), obstacles=[kerb], ground=True, bounds=BOUNDS, view="front")
    stage = build_stage(picture, at(0.0, 0.0, 0.3)[None], SIZE)
    column, row = stage.pen.camera.project([0.0, -0.45, 0.15], SIZE)[:2].astype(int)
    image = shot(stage, at(0.0, 0.0, 0.3))
    assert (image[row, column] == stage.image[row, column]).all()
    assert reddish(image).any()


def test_one_looks_into_a_room_through_its_near_walls() -> None:
    wall = box_surface("room", (4.0, 4.0, 2.0), (0.0, 0.0, 1.0))
    room = replace(wall, faces=wall.faces[:, ::-1].copy())
    picture = Picture(bodies=ball(0.4), obstacles=[room])
    assert reddish(frame(picture, at(0.0, 0.0, 1.0))).any()
    stage = build_stage(picture, at(0.0, 0.0, 1.0)[None], SIZE)
    assert not stage.still.outlook.veiled[0].any()
    solid = build_stage(replace(picture, obstacles=[wall]), at(0.0, 0.0, 1.0)[None], SIZE)
    assert solid.still.outlook.veiled[0].any()


def test_a_turning_disk_looks_different_at_every_eighth_turn() -> None:
    picture = Picture(bodies=[BodyGeometry("coin", (Disk(0.5, 0.1, "y"),))], view="front")
    images = []
    for angle in np.arange(8) * np.pi / 4.0:
        c, s = np.cos(angle), np.sin(angle)
        turned = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0]], dtype=float)
        stage = build_stage(picture, at(0, 0, 0)[None], SIZE)
        images.append(shot(stage, turned.reshape(1, 12)).astype(int))
    for i in range(8):
        for j in range(i):
            different = (abs(images[i] - images[j]).max(axis=-1) > 60).mean()
            assert different > 0.02  # of the picture, a third of which is the coin


def test_ground_is_drawn_only_below() -> None:
    picture = Picture(bodies=ball(0.2), ground=True, bounds=BOUNDS)
    fallen = replace(picture, up=np.array([-1.0, 0.0, 0.0]))
    assert picture.stands_on_ground
    assert not fallen.stands_on_ground
    assert build_stage(fallen, at(0, 0, 1)[None], SIZE).still.floor is None


def test_the_goal_is_green_and_the_start_is_a_ghost() -> None:
    bare = Picture(bodies=ball(0.2), ground=True, bounds=BOUNDS)
    pose = at(0.0, 0.0, 0.2)
    plain = build_stage(bare, pose[None], SIZE).image.astype(int)
    goal = GoalMarker((1.5, 1.5, 0.0), 0.4)
    marked = build_stage(replace(bare, goal=goal), pose[None], SIZE)
    column, row = marked.pen.camera.project([1.5, 1.5, 0.0], SIZE)[:2].astype(int)
    red, green, blue = marked.image[row, column].astype(int)
    assert green > max(red, blue) + 20
    ghost = build_stage(replace(bare, start=Ghost(at(-1.0, 0.0, 0.2))), pose[None], SIZE)
    assert not reddish(ghost.image).any()
    assert (ghost.image != plain).any()


def test_the_path_lies_on_the_floor_under_the_motion() -> None:
    line = np.column_stack([np.linspace(-1.5, 1.5, 30), np.zeros(30), np.ones(30)])
    bare = Picture(bodies=(), ground=True, bounds={**BOUNDS, "z": (0.0, 1.0)})
    none = np.zeros((1, 0, 12))
    plain, drawn = (build_stage(p, none, SIZE) for p in (bare, replace(bare, path=line)))
    for x in (-1.25, 0.25, 1.25):
        column, row = plain.pen.camera.project([x, 0.0, 0.0], SIZE)[:2].astype(int)
        assert drawn.image[row, column, 0] < plain.image[row, column, 0] - 60


def test_a_cable_is_drawn_and_a_slack_one_is_not() -> None:
    bodies = [BodyGeometry("load", (Box(0.2, 0.2, 0.2),), color=RED)]
    cable = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 0.1]]])
    picture = Picture(bodies=bodies, bounds={"z": (0.0, 1.0)}, view="front")
    stage = build_stage(picture, at(0, 0, 0)[None], SIZE)
    column, row = stage.pen.camera.project([0.0, 0.0, 0.6], SIZE)[:2].astype(int)
    assert (shot(stage, at(0, 0, 0), cable)[row, column] < 120).all()
    slack = shot(stage, at(0, 0, 0), np.full((1, 2, 3), np.nan))
    assert (slack == shot(stage, at(0, 0, 0))).all()


def test_an_empty_picture_is_paper() -> None:
    image = frame(Picture(bodies=()), np.zeros((0, 12)))
    assert image.shape == (300, 400, 3)
    assert (image[100:] == image[-1, -1]).all()


def test_the_same_picture_has_the_same_pixels() -> None:
    picture = Picture(bodies=ball(0.2), ground=True, bounds=BOUNDS)
    first, second = (frame(picture, at(0, 0, 1)) for _ in range(2))
    assert (first == second).all()


def test_a_cone_tints_what_lies_behind_it_and_points_where_it_should() -> None:
    """A red cone along +x: red pixels on that side of its apex only."""
    cone = Cone((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 0.3, 1.5, forbidden=True)
    pose = at(0.0, 0.0, 1.0)
    bare, tinted = (
        build_stage(Picture(bodies=ball(0.1), bounds=BOUNDS, cones=cones), pose[None], SIZE)
        for cones in ((), (cone,))
    )
    red = tinted.image[..., 0].astype(int) - tinted.image[..., 2] > 20
    assert red.sum() > 500
    column = tinted.pen.camera.project([0.0, 0.0, 1.0], SIZE)[0]
    ahead = tinted.pen.camera.project([1.0, 0.0, 1.0], SIZE)[0] - column
    places = np.nonzero(red)[1] - column
    assert (np.sign(ahead) * places > -5.0).all()
    assert bare.image.shape == tinted.image.shape


@pytest.mark.parametrize("forbidden", [False, True])
def test_a_cone_is_closed_and_has_its_volume(forbidden: bool) -> None:
    """2/3 pi r^3 (1 - cos a), flat facets inside it missing up to 2 %."""
    mesh = cone_mesh(Cone((1.0, 2.0, 3.0), (0.0, 0.6, -0.8), 0.5, 2.0, forbidden))
    a, b, c = (mesh.vertices[mesh.faces[:, i]] - [1.0, 2.0, 3.0] for i in range(3))
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert (mesh.sides[:, 0] != mesh.sides[:, 1]).all()
    assert volume == pytest.approx(2 / 3 * np.pi * 8.0 * (1 - np.cos(0.5)), rel=0.02)
    assert np.linalg.norm(mesh.vertices - [1.0, 2.0, 3.0], axis=1).max() == pytest.approx(2.0)


def test_a_cable_is_as_wide_as_its_radius_and_never_thinner_than_a_line() -> None:
    """A bar of 0.2 m beside the cable measures what 0.2 m are in the picture."""
    cable, widths = np.array([[[0.0, 0.0, 0.1], [0.0, 0.0, 1.0]]]), []
    for radius in (0.0, 0.001, 0.1):
        picture = Picture(bodies=ball(0.02), bounds=BOUNDS, view="front", radii=np.array([radius]))
        stage = build_stage(picture, at(0, 0, 0)[None], SIZE)
        ends = stage.pen.camera.project([[-0.1, 0.0, 0.5], [0.1, 0.0, 0.5]], SIZE)[:, :2]
        _, row = ends[0].astype(int)
        widths.append(int((shot(stage, at(0, 0, 0), cable)[row].max(axis=-1) < 120).sum()))
    assert widths[0] == widths[1]  # [pixel]
    assert widths[2] == pytest.approx(np.ptp(ends[:, 0]), abs=2.0)


def test_the_ghosts_cable_is_drawn() -> None:
    bare = Picture(bodies=ball(0.02), bounds=BOUNDS, view="front", radii=np.array([0.1]))
    cable = np.array([[[1.0, 0.0, 0.1], [1.0, 0.0, 1.0]]])
    pose = at(0.0, 0.0, 0.0)
    marked = build_stage(replace(bare, start=Ghost(pose, cable)), pose[None], SIZE)
    column, row = marked.pen.camera.project([1.0, 0.0, 0.5], SIZE)[:2].astype(int)
    assert (marked.image[row, column] < marked.image[2, 2] - 20).all()


def test_start_and_goal_of_a_machine_without_cables_are_drawn() -> None:
    problem = kinolab.load("pendulum_swingup")
    x = np.array([problem.start, problem.start])
    shown = picture_of(problem, x)
    assert isinstance(shown.goal, Ghost)
    for ghost in (shown.start, shown.goal):
        assert ghost is not None
        assert ghost.lines.shape == (0, 2, 3)


def test_a_machine_of_which_nothing_is_seen_has_a_picture() -> None:
    """A robot whose file has masses alone: its start and its goal add nothing to the picture."""
    pose = at(0.0, 0.0, 0.5)
    bare = Picture(bodies=[BodyGeometry("mass", ())], bounds=BOUNDS)
    ghost = Ghost(pose, np.zeros((0, 2, 3)))
    marked = build_stage(replace(bare, start=ghost, goal=ghost), pose[None], SIZE)
    assert np.array_equal(marked.image, build_stage(bare, pose[None], SIZE).image)
