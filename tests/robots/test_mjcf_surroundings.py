"""What stands around a robot in an MJCF file is in its way, planes included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import EndpointError
from kinolab.problem.task import PlanningTask
from kinolab.problem.warnings import problem_warnings
from kinolab.robots import read_mjcf

pytest.importorskip("mujoco")

RADIUS = 0.1  # [m], of the puck
NEAR = 1e-4  # [m], more than a collision check's reserve
PUCK = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    {}
    <body name="puck" pos="0 0 0.5">
      <joint name="x" type="slide" axis="1 0 0" range="-3 3"/>
      <joint name="z" type="slide" axis="0 0 1" range="-3 3"/>
      <geom type="sphere" size="0.1" mass="1"/>
    </body>
  </worldbody>
  <actuator><motor name="px" joint="x" ctrlrange="-50 50"/>
    <motor name="pz" joint="z" ctrlrange="-50 50"/></actuator>
</mujoco>"""
GROUND = '<geom type="plane" size="2 2 0.1"/>'


def task(folder: Path, geoms: str, world: str = "") -> PlanningTask:
    """Return the problem of a puck among some geoms."""
    (folder / "puck.xml").write_text(PUCK.format(geoms))
    text = 'schema = 1\ntitle = "A puck"\n[system]\nfile = "puck.xml"\n[goal]\nx = 0.001\n'
    bounds = "[bounds]\nx_dot = [-2, 2]\nz_dot = [-2, 2]\n"
    (folder / "puck.toml").write_text(text + bounds + world)
    return kinolab.load(folder / "puck.toml")


def touches(problem: PlanningTask, x: float, z: float) -> bool:
    """Whether the puck touches anything, moved from 0.5 m above the origin."""
    state = np.zeros(problem.model.nx)
    names = problem.model.state_names
    state[names.index("x")], state[names.index("z")] = x, z
    return bool(problem.checker().collides(*problem.placement(state)))


@pytest.mark.parametrize(
    ("plane", "point", "normal"),
    [
        ('pos="1 0 0" zaxis="-1 0 0"', (1, 0, 0), (-1, 0, 0)),
        ('pos="-0.7 3 9" zaxis="1 0 0"', (-0.7, 0, 0), (1, 0, 0)),
        ('pos="0 0 -0.4"', (0, 0, -0.4), (0, 0, 1)),  # a floor that is not at z = 0
        ('pos="0 0 2" zaxis="0 0 -1"', (0, 0, 2), (0, 0, -1)),  # a ceiling
        ('pos="0 0 -1" zaxis="-1 0 2"', (0, 0, -1), (-1 / 5**0.5, 0, 2 / 5**0.5)),  # a ramp
        ('pos="0.9 0 0" zaxis="-3 4 0"', (0.9, 0, 0), (-0.6, 0.8, 0)),
        ('pos="1 0 0" euler="0 -1.5707963267948966 0"', (1, 0, 0), (-1, 0, 0)),
        ('pos="1 5e3 -4e7" zaxis="-1 0 0"', (1, 0, 0), (-1, 0, 0)),  # it has no end
        ('pos="-6e9 0 -0.4"', (0, 0, -0.4), (0, 0, 1)),
    ],
)
def test_a_plane_stops_a_ball_where_it_touches_it(
    tmp_path: Path,
    plane: str,
    point: tuple[float, float, float],
    normal: tuple[float, float, float],
) -> None:
    """The ball's centre is n . (c - p) above a plane through p with the normal n."""
    problem = task(tmp_path, f'<geom type="plane" size="1 1 0.1" {plane}/>')
    n, p, c = (np.array(entry, dtype=float) for entry in (normal, point, (0.0, 0.0, 0.5)))
    gap = float(n @ (c - p)) - RADIUS
    along = -n[[0, 2]] / (n[0] ** 2 + n[2] ** 2)  # moves nearer by 1 m for each metre of the gap
    assert gap > 0.0
    assert not touches(problem, *(along * (gap - NEAR)))
    assert touches(problem, *(along * (gap + NEAR)))
    assert touches(problem, *(along * (gap + 1.0)))


@pytest.mark.parametrize(
    "geom",
    ['<geom type="box" pos="1.05 0 0" size="0.05 2 2"/>',
     '<body pos="0 0 1"><geom type="box" pos="1.05 0 0" size="0.05 2 2"/></body>',
     '<geom type="box" pos="0 0 0.2" size="0.1 0.1 0.2"/><geom type="box" pos="1.05 0 0" '
     'size="0.05 2 2"/>',  # the puck rests on the first one
     '<body euler="0 0 0.7854"><body euler="0 0 -0.7854"><geom type="plane" pos="1 0 0" '
     'zaxis="-1 0 0" size="1 1 1"/></body></body>'],
)  # fmt: skip
def test_what_is_fixed_to_the_world_stops_bodies_whose_joints_hang_from_it(
    tmp_path: Path, geom: str
) -> None:
    problem = task(tmp_path, geom)
    assert not touches(problem, 0.9 - NEAR, 0.0)
    assert touches(problem, 0.9 + NEAR, 0.0)


@pytest.mark.parametrize(
    ("joints", "floor", "kept"),
    [
        ('axis="1 0 0"', 'type="box" size="5 5 0.1" pos="0 0 0.3"', False),
        ('axis="0 0 1"', 'type="box" size="5 5 0.1" pos="0 0 0.3"', True),
        ('axis="0 0 1"', 'type="plane" size="1 1 1" pos="0 0 0.4"', True),
        ('axis="1 0 0"', 'type="plane" size="1 1 1" pos="0 0 0.4"', False),
        ('axis="0 0 1"', 'type="box" size="0.05 0.05 0.1" pos="0 0 0.5"', False),
    ],
)
def test_what_rests_on_a_floor_may_slide_on_it_and_not_sink_in(
    tmp_path: Path, joints: str, floor: str, kept: bool
) -> None:
    """The last one is a pedestal inside of it, which it never was apart from."""
    file = tmp_path / "puck.xml"
    file.write_text(f"""<mujoco><worldbody><geom name="floor" {floor}/>
      <body name="puck" pos="0 0 0.5"><joint name="j" type="slide" {joints}/>
      <geom type="sphere" size="0.1" mass="1"/></body></worldbody></mujoco>""")
    assert (("world floor", "puck") in read_mjcf(file).collisions) is kept


@pytest.mark.parametrize(
    ("geoms", "left_out"),
    [
        ('<geom name="box" type="box" size="1 1 0.2" pos="0 0 0.22"/>', ("world box", "puck")),
        ('<geom name="hill" type="plane" size="1 1 1" pos="0 0 0.45" zaxis="1 0 3"/>',
         ("world hill 2", "puck")),
        ('<body name="table" pos="0 0 0.2"><geom name="top" type="box" size="1 1 0.25"/></body>',
         ("table top", "puck")),
    ],
)  # fmt: skip
def test_surroundings_that_a_robot_is_in_are_told(
    tmp_path: Path, geoms: str, left_out: tuple[str, str]
) -> None:
    problem = task(tmp_path, geoms)
    assert problem.system.unwatched == (left_out,)
    assert any(" and ".join(left_out) in one for one in problem_warnings(problem))


@pytest.mark.parametrize("second", ["", '<joint axis="1 0 0"/>'])
def test_what_turns_on_a_pedestal_is_in_it_without_a_word(tmp_path: Path, second: str) -> None:
    """As neighbours are; what hangs farther out is watched, or told."""
    file = tmp_path / "arm.xml"
    text = """<mujoco><worldbody><body name="pedestal"><geom size="0.2" pos="0 0 0.5"/>
      <body name="upper" pos="0 0 0.5"><joint axis="0 1 0"/>{}<geom size="0.1" mass="1"/>
        <body name="lower" pos="0.1 0 0"><joint axis="0 1 0"/><geom size="0.1" mass="1"/>
        <body name="hand" pos="0.5 0 0"><joint axis="0 1 0"/><geom size="0.1" mass="1"/>
      </body></body></body></body></worldbody></mujoco>"""
    file.write_text(text.format(second))
    system = read_mjcf(file)
    assert system.unwatched == (("pedestal geom_1", "lower"),)
    assert ("pedestal geom_1", "hand") in system.collisions


def test_surroundings_count_without_self_collisions(tmp_path: Path) -> None:
    file = tmp_path / "puck.xml"
    file.write_text(PUCK.format('<geom name="wall" type="box" pos="1 0 0" size="0.05 2 2"/>'))
    system = read_mjcf(file, self_collisions=False)
    assert system.collisions == (("world wall", "puck"),)


def test_what_moves_freely_keeps_apart_from_a_floor_at_its_origin(tmp_path: Path) -> None:
    """A free body's coordinates are 0 at the world's origin, wherever its file begins."""
    file = tmp_path / "free.xml"
    file.write_text("""<mujoco><worldbody><geom name="slab" type="box" size="1 1 0.1"/>
      <body name="ball" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>""")
    assert read_mjcf(file).collisions == (("world slab", "ball"),)


def test_the_ground_is_the_scenario_s_and_walls_stand_on_it(tmp_path: Path) -> None:
    wall = '<geom type="plane" pos="1 0 0" zaxis="-1 0 0" size="1 1 1"/>'
    without = task(tmp_path, GROUND + wall)
    assert not touches(without, 0.0, -0.4 - NEAR)
    with_ground = task(tmp_path, GROUND + wall, '[world]\nground = "plane"\n')
    assert touches(with_ground, 0.0, -0.4 - NEAR)
    assert not touches(with_ground, 0.9 - NEAR, 0.0)
    assert touches(with_ground, 0.9 + NEAR, 0.0)


def test_a_plane_has_no_end_where_a_robot_goes_far(tmp_path: Path) -> None:
    """Kilometres behind a wall, and along a floor."""
    wall = '<geom type="plane" pos="1 0 0" zaxis="-1 0 0" size="1 1 1"/>'
    assert touches(task(tmp_path, wall), 5e3, 0.0)
    floor = task(tmp_path, '<geom type="plane" pos="0 0 0.1" size="1 1 1"/>')
    assert not touches(floor, -5e3, NEAR - 0.3)
    assert touches(floor, -5e3, -NEAR - 0.3)


def test_planes_that_do_not_collide_are_pictures(tmp_path: Path) -> None:
    plane = '<geom type="plane" pos="1 0 0" zaxis="-1 0 0" size="1 1 1" {}/>'
    drawn = plane.format('contype="0" conaffinity="0"')
    assert not touches(task(tmp_path, drawn), 2.0, 0.0)
    assert touches(task(tmp_path, plane.format('contype="2"')), 2.0, 0.0)


def test_a_goal_behind_a_wall_is_refused(tmp_path: Path) -> None:
    wall = '<geom name="wall" type="plane" pos="1 0 0" zaxis="-1 0 0" size="2 2 .1"/>'
    task(tmp_path, wall)
    text = (tmp_path / "puck.toml").read_text().replace("x = 0.001", "x = 2.0")
    (tmp_path / "far.toml").write_text(text)
    with pytest.raises(EndpointError, match="world wall touches puck"):
        kinolab.load(tmp_path / "far.toml").solve(seed=1, time_limit=1.0)


def test_what_stands_may_stand_beyond_the_bounds_of_the_world(tmp_path: Path) -> None:
    """They hold for what moves; the origin of a table, or of the solid below a ramp, may be out."""
    ramp = '<geom type="plane" size="2 2 0.1" pos="0 0 -3" zaxis="1 0 2"/>'
    box = '<geom type="box" size="0.1 1 0.1" pos="1.5 0 0.5"/>'
    bounds = "[world]\nbounds = { x = [-1, 1], z = [0, 2] }\n"
    problem = task(tmp_path, ramp + box, bounds)
    problem.check_endpoints()
    still = problem.start[None].repeat(2, axis=0)
    still[1, problem.model.state_names.index("x")] = 1.001
    assert problem.outside_limits(still).tolist() == [False, True]
    assert (problem.limit_excess(still).max(axis=1) > 0).tolist() == [False, True]
    margins = problem.pose_margins(problem.model.frames(still)).min(axis=1)
    assert (margins < 0).tolist() == [False, True]
    for planner in ("rrt", "rrt_fast"):
        assert problem.solve(planner=planner, seed=1, time_limit=20.0, optimize=False).trajectory


def test_planes_are_drawn_and_the_path_is_that_of_what_moves(tmp_path: Path) -> None:
    """A patch as large as the file has it, or the model is; the ground is the scenario's."""
    walls = '<geom name="a" type="plane" size="2 1 0.1" pos="0 0 3" zaxis="0 0 -1"/>'
    endless = '<geom name="b" type="plane" size="0 0 0.1" pos="9 0 0" zaxis="-1 0 0"/>'
    problem = task(tmp_path, GROUND + walls + endless)
    assert problem.bodies[problem.leading].name == "puck"
    drawn = {body.name: body.drawn for body in problem.bodies if body.drawn}
    sizes = {name: np.ptp(parts[0].vertices, axis=0) for name, parts in drawn.items()}
    np.testing.assert_allclose(sizes["world a"], [4, 2, 0], atol=1e-6)
    extent = read_mjcf_extent(tmp_path / "puck.xml")
    np.testing.assert_allclose(np.sort(sizes["world b"]), [0, 2 * extent, 2 * extent], atol=1e-6)


def read_mjcf_extent(file: Path) -> float:
    """How large MuJoCo says a model is, in [m]."""
    import mujoco

    return float(mujoco.MjModel.from_xml_path(str(file)).stat.extent)
