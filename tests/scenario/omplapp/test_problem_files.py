"""OMPL.app's problem files as problems of kinolab, and what is wrong with a file that is none."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.dynamics.language.shapes import Box
from kinolab.errors import InputError
from kinolab.loading import find_machine, find_scenario
from kinolab.loading.omplapp_problem import read_problem_file
from kinolab.numerics.arrays import Array
from kinolab.robots.solids import overhang
from kinolab.robots.tree.kinematic_tree import PlacedShape
from tests.scenario.omplapp.cad_files import collada, geometry, nested, obj, written
from tests.support import needs

# A bar of 2 x 1 x 0.5, of which OMPL.app takes (11, 20.5, 5.25) for the centre.
BAR = obj(((10.0, 20.0, 5.0), (12.0, 21.0, 5.5)))
CENTRE = (11.0, 20.5, 5.25)
# Two walls with a gap of 2 between them, at x = 0, from z = 4 to 7.
WALLS = obj(((-0.25, -6.0, 4.0), (0.25, -1.0, 7.0)), ((-0.25, 1.0, 4.0), (0.25, 6.0, 7.0)))

PLANE = """\
# a bar goes through a gap
[problem]
name = gap
robot = bar.obj   ; not a comment
world = walls.obj # a comment
start.x = -4.0
start.y = 0.5
start.theta = 1.5707963267948966
goal.x = 4
goal.y = -0.5
goal.theta = -1.5707963267948966
volume.min.x = -6
volume.min.y = -6
volume.max.x = 6
volume.max.y = 6

[benchmark]
time_limit = 25.0
mem_limit = 1000.0
run_count = 3

[planner]
kpiece =
kpiece.goal_bias = 0.2
"""
PLANE = PLANE.replace("   ; not a comment", "")

SPACE = """\
problem.robot = bar.obj
problem.world = walls.obj
[problem]
start.x = -4.0
start.y = 0.0
start.z = 5.5
start.theta = 0.5
start.axis.x = 1.0
start.axis.y = 2.0
start.axis.z = -2.0
goal.x = 4.0
goal.y = 0.0
goal.z = 5.5
goal.theta = 0
goal.axis.x = 0
goal.axis.y = 0
goal.axis.z = 0
"""


@pytest.fixture(scope="module", autouse=True)
def _the_same_robot_is_enclosed_once() -> Iterator[None]:
    """Finding solids around a robot takes most of the time of loading, and most have this bar."""
    made: dict[tuple[bytes, bytes], tuple[list[PlacedShape], float]] = {}
    true = overhang.closest_solids

    def remembered(triangles: Array, within: Array) -> tuple[list[PlacedShape], float]:
        key = triangles.tobytes(), within.tobytes()
        if key not in made:
            made[key] = true(triangles, within)
        return made[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(overhang, "closest_solids", remembered)
        yield


def problem_file(folder: Path, text: str = PLANE, name: str = "gap.cfg") -> Path:
    """Write a problem file beside the meshes, and return its path."""
    written(folder, bar_obj=BAR, walls_obj=WALLS)
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def without(text: str, *keys: str) -> str:
    """Return a file without the lines of some keys."""
    kept = (line for line in text.splitlines() if line.partition("=")[0].strip() not in keys)
    return "\n".join(kept) + "\n"


# --- what a file says ---


def test_a_file_in_the_plane_is_a_problem(tmp_path: Path) -> None:
    problem = kinolab.load(problem_file(tmp_path))
    assert (problem.name, problem.system.name) == ("gap", "planar_body")
    assert problem.scenario.title == "gap (OMPL.app)"
    assert problem.start.tolist() == [-4.0, 0.5, math.pi / 2]
    assert problem.goal.targets.tolist() == [4.0, -0.5, -math.pi / 2]
    assert problem.bounds[:2].tolist() == [[-6.0, 6.0], [-6.0, 6.0]]
    planner = problem.scenario.planner
    assert (planner.name, planner.time_limit) == ("kpiece", 25.0)
    assert planner.settings == {"goal_bias": 0.2}
    assert [o.name for o in problem.world.obstacles] == ["walls"]


def test_the_robot_turns_about_the_mean_of_its_vertices(tmp_path: Path) -> None:
    """In the plane it keeps its height: OMPL.app centres x and y alone."""
    problem = kinolab.load(problem_file(tmp_path))
    (body,) = problem.system.bodies
    (shape,) = body.shapes
    assert isinstance(shape, Box)
    assert (shape.x, shape.y, shape.z) == pytest.approx((2.0, 1.0, 0.5))
    assert shape.at == pytest.approx((0.0, 0.0, CENTRE[2]))


def test_a_file_in_space_is_a_problem(tmp_path: Path) -> None:
    problem = kinolab.load(problem_file(tmp_path, SPACE))
    assert (problem.name, problem.system.name) == ("gap", "free_body")
    turn = Rotation.from_rotvec(0.5 * np.array([1.0, 2.0, -2.0]) / 3.0).as_quat()
    assert problem.start.tolist() == pytest.approx([-4.0, 0.0, 5.5, *turn])
    (attitude,) = problem.goal.parts
    assert attitude.target == pytest.approx([0.0, 0.0, 0.0, 1.0])
    (body,) = problem.system.bodies
    assert body.shapes[0].at == pytest.approx((0.0, 0.0, 0.0))


def test_without_a_volume_the_world_and_both_ends_limit_the_place(tmp_path: Path) -> None:
    text = SPACE.replace("goal.z = 5.5", "goal.z = 9.5")
    problem = kinolab.load(problem_file(tmp_path, text))
    assert problem.bounds[:3].tolist() == [[-4.0, 4.0], [-6.0, 6.0], [4.0, 9.5]]


def test_start_and_goal_widen_a_volume(tmp_path: Path) -> None:
    text = PLANE.replace("volume.max.x = 6", "volume.max.x = 3")
    problem = kinolab.load(problem_file(tmp_path, text))
    assert problem.bounds[:2].tolist() == [[-6.0, 4.0], [-6.0, 6.0]]


def test_a_free_body_crosses_its_volume_in_twenty_seconds(tmp_path: Path) -> None:
    problem = kinolab.load(problem_file(tmp_path))
    assert [entry.limit for entry in problem.system.inputs] == [0.6, 0.6, 1.0]


def test_keys_of_the_scenario_may_be_set(tmp_path: Path) -> None:
    problem = kinolab.load(problem_file(tmp_path), overrides=["planner.name=auto", "start.x=-3"])
    assert (problem.scenario.planner.name, problem.start[0]) == ("auto", -3.0)
    with pytest.raises(InputError, match=r"^--set plamner.seed=7: "):
        kinolab.load(problem_file(tmp_path), overrides=["plamner.seed=7"])


def test_machine_and_scenario_are_found_by_the_file(tmp_path: Path) -> None:
    file = str(problem_file(tmp_path))
    assert find_machine(file).name == "planar_body"
    assert find_scenario(file).title == "gap (OMPL.app)"


def test_a_mesh_in_a_folder_below_or_by_its_whole_path(tmp_path: Path) -> None:
    """OMPL.app's window writes whole paths."""
    written(tmp_path / "cad", bar_obj=BAR)
    whole = str((tmp_path / "cad" / "bar.obj").resolve())
    problem = kinolab.load(problem_file(tmp_path, PLANE.replace("= walls.obj", f"= {whole}")))
    assert problem.scenario.world.obstacle[0].mesh == "cad/bar.obj"


# --- COLLADA ---

# What assimp 5 makes of tests/scenario/omplapp/cad_files.nested, in a unit of half a metre: lowest
# and highest coordinates, and the mean of its 72 vertices.
SINGLE = 1e-6  # pycollada multiplies with single precision
ASSIMP = {
    "X_UP": ((-1.0, -2.5, 1.5), (0.0, 5.0, 5.5), (-0.5, 5 / 6, 43 / 12)),
    "Y_UP": ((-2.5, 0.0, 1.5), (5.0, 1.0, 5.5), (5 / 6, 0.5, 43 / 12)),
    "Z_UP": ((-2.5, 1.5, -1.0), (5.0, 5.5, 0.0), (5 / 6, 43 / 12, -0.5)),
}


@pytest.mark.parametrize("up", ASSIMP)
def test_collada_is_where_assimp_has_it(up: str, tmp_path: Path) -> None:
    """As an obstacle and as a robot: nodes within nodes, units, and y up."""
    low, high, mean = ASSIMP[up]
    written(tmp_path, nested_dae=nested(up=up))
    text = SPACE.replace("bar.obj", "nested.dae").replace("walls.obj", "nested.dae")
    problem = kinolab.load(problem_file(tmp_path, text))
    (obstacle,) = problem.world.obstacles
    assert obstacle.vertices.min(axis=0) == pytest.approx(low, abs=SINGLE)
    assert obstacle.vertices.max(axis=0) == pytest.approx(high, abs=SINGLE)
    centres = np.array([shape.at for shape in problem.system.bodies[0].shapes], dtype=float)
    halves = np.array([[s.x, s.y, s.z] for s in problem.system.bodies[0].shapes], dtype=float) / 2
    assert (centres - halves).min(axis=0) == pytest.approx(np.subtract(low, mean), abs=SINGLE)
    assert (centres + halves).max(axis=0) == pytest.approx(np.subtract(high, mean), abs=SINGLE)


@needs("collada")
def test_without_a_word_on_it_y_is_up_and_the_unit_a_metre(tmp_path: Path) -> None:
    box = geometry("box", (0, 0, 0), (1, 2, 3))
    whole = collada([box], '<node><instance_geometry url="#box"/></node>')
    written(tmp_path, box_dae=whole)
    problem = kinolab.load(problem_file(tmp_path, SPACE.replace("walls.obj", "box.dae")))
    assert problem.world.obstacles[0].vertices.max(axis=0) == pytest.approx((1.0, 2.0, 3.0))


# --- machines ---


def test_a_car_is_driven_to_within_the_threshold(tmp_path: Path) -> None:
    """OMPL.app's distance weighs angles by a half, speed and steering by 0.3."""
    text = PLANE.replace("name = gap", "control = dynamic_car\nthreshold = 0.6")
    problem = kinolab.load(problem_file(tmp_path, text))
    assert problem.system.name == "dynamic_car"
    section = problem.scenario.goal
    assert section.norm == "sum"
    wanted = {"x": 0.6, "y": 0.6, "theta": 1.2, "v": 2.0, "phi": 2.0}
    assert {name: section.tolerance_of(name) for name in wanted} == pytest.approx(wanted)
    assert section.values["v"] == section.values["phi"] == 0.0


@pytest.mark.parametrize(("space", "limits"), [("dubins", (0.0, 0.6)), ("reedsshepp", (-0.6, 0.6))])
def test_state_spaces_of_cars_have_their_tightest_turn(
    space: str, limits: tuple[float, float], tmp_path: Path
) -> None:
    text = PLANE.replace("name = gap", f"statespace = {space}\nturningradius = 2.5")
    problem = kinolab.load(problem_file(tmp_path, text))
    speed, steering = problem.system.inputs
    assert speed.limit == pytest.approx(limits)
    model = problem.model
    rate = model.f(np.zeros(3), np.array([1.0, float(steering.limit)]))[2]  # type: ignore[arg-type]
    assert rate == pytest.approx(1.0 / 2.5)


def test_the_blimp_keeps_its_heading_alone(tmp_path: Path) -> None:
    text = SPACE.replace("start.z", "control = blimp\nstart.z")
    problem = kinolab.load(problem_file(tmp_path, text))
    _, _, z, w = Rotation.from_rotvec(0.5 * np.array([1.0, 2.0, -2.0]) / 3.0).as_quat()
    assert problem.start[3] == pytest.approx(2.0 * math.atan2(z, w))
    assert any("has the heading alone" in note for note in problem.notes)


def test_a_quadrotor_that_only_falls_is_refused(tmp_path: Path) -> None:
    text = SPACE.replace("start.z", "control = quadrotor\nstart.z")
    (mistake,) = mistakes_in(tmp_path, text)
    assert mistake.startswith("gap.cfg line 8 start.theta: OMPL.app's quadrotor pushes along minus")
    for key, value in {"theta": "3.1416", "axis.y": "0", "axis.z": "0"}.items():
        text = without(text, f"start.{key}") + f"start.{key} = {value}\n"
    kinolab.load(problem_file(tmp_path, text)).check_endpoints()


# --- planners ---


def notes_on(folder: Path, *planners: str) -> tuple[str, tuple[str, ...]]:
    """Return the planner of a file that names some, and what is said of it."""
    text = PLANE[: PLANE.index("kpiece")] + "".join(f"{name}=\n" for name in planners)
    problem = kinolab.load(problem_file(folder, text))
    return problem.scenario.planner.name, problem.notes[1:]


def test_several_planners_leave_the_choice_to_kinolab(tmp_path: Path) -> None:
    name, notes = notes_on(tmp_path, "est", "rrt", "sbl", "prm")
    assert (name, notes) == (
        "auto",
        (
            "kinolab has no sbl, prm here; kpiece_fast works instead.",
            "The file compares planners. kinolab has est, rrt. --planner NAME takes one of them.",
        ),
    )


def test_a_planner_that_is_not_here_is_told(tmp_path: Path) -> None:
    name, notes = notes_on(tmp_path, "rrtstar")
    assert (name, notes) == (
        "auto",
        ("kinolab has no rrtstar here; ao_rrt works instead.",),
    )


@pytest.mark.parametrize(("theirs", "ours"), [("pdst", "pdst"), ("SycLOPrrt", "syclop_rrt")])
def test_planners_that_both_have_are_taken(theirs: str, ours: str, tmp_path: Path) -> None:
    assert notes_on(tmp_path, theirs) == (ours, ())


def test_settings_that_mean_something_else_are_told(tmp_path: Path) -> None:
    text = PLANE.replace(
        "kpiece.goal_bias", "kpiece.range = 5\nproblem.sampler = x\nkpiece.goal_bias"
    )
    problem = kinolab.load(problem_file(tmp_path, text))
    assert problem.notes[1:] == ("kpiece has no setting range.",)


def test_objectives_are_told(tmp_path: Path) -> None:
    text = PLANE.replace("name = gap", "objective = max_min_clearance\nsampler = gaussian")
    assert kinolab.load(problem_file(tmp_path, text)).notes[1:] == (
        "kinolab makes motions short in time; objective max_min_clearance is not its.",
        "sampler: kinolab has no such setting.",
    )
    text = PLANE.replace("name = gap", "objective = length")
    assert kinolab.load(problem_file(tmp_path, text)).notes[1:] == ()


# --- mistakes ---


def mistakes_in(folder: Path, text: str) -> list[str]:
    path = problem_file(folder, text)
    scenario, mistakes = read_problem_file(path)
    assert scenario is None
    with pytest.raises(InputError) as caught:
        kinolab.load(path)
    assert list(caught.value.mistakes) == mistakes
    return [str(mistake) for mistake in mistakes]


def test_all_mistakes_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    text = """\
[problem]
robot = car.obj
world = ../walls.obj
start.x = one
start.y = 0
strat.theta = 0
goal.x = 1
goal.y = 1e999
goal.theta = 0
goal.theta = 1
control = unicycle
volume.min.x = 1
just words
[bench]
[benchmark]
time_limit = 0
memory = 5
[planner]
rtt =
"""
    at = tmp_path.resolve()
    wanted = [
        f"gap.cfg line 2 robot: car.obj does not exist. Mesh files are looked up from {at}.",
        f"gap.cfg line 3 world: ../walls.obj lies outside {at}. Copy the mesh beside its scenario.",
        "gap.cfg line 4 start.x: 'one' is no finite number.",
        "gap.cfg line 6 strat.theta: no key is called 'strat.theta'. Did you mean 'start.theta'?",
        "gap.cfg line 8 goal.y: '1e999' is no finite number.",
        "gap.cfg line 10 goal.theta: goal.theta stands in line 9 already. Keep one of them.",
        "gap.cfg line 11 control: no control is called 'unicycle'. "
        "Known: blimp, dynamic_car, kinematic_car, quadrotor.",
        "gap.cfg line 12 volume.min.x: volume.min.y, volume.max.x, volume.max.y are missing. "
        "Give all limits, or none: then the world decides.",
        "gap.cfg line 13: 'just words' is no key = value.",
        "gap.cfg line 14 [bench]: no section is called 'bench'. Did you mean 'benchmark'?",
        "gap.cfg line 16 time_limit: '0' is no positive number.",
        "gap.cfg line 17 memory: no key is called 'memory'. Known: time_limit, mem_limit",
        "gap.cfg line 19 rtt: no planner is called 'rtt'. Did you mean 'rrt'?",
        "gap.cfg: [problem] start.theta is missing. "
        "In the plane, give start.x, start.y, start.theta.",
    ]
    found = mistakes_in(tmp_path, text)
    assert len(found) == len(wanted)
    assert [mistake[: len(start)] for mistake, start in zip(found, wanted, strict=True)] == wanted


def test_a_section_that_is_missing(tmp_path: Path) -> None:
    (mistake,) = mistakes_in(tmp_path, "[planner]\nrrt=\n")
    assert mistake == (
        "gap.cfg: the section [problem] is missing, or empty. Give robot, world, start and goal."
    )


def test_a_control_of_the_other_world(tmp_path: Path) -> None:
    (first,) = mistakes_in(tmp_path, PLANE.replace("name = gap", "control = blimp"))
    assert first == (
        "gap.cfg line 3 control: blimp moves in space. Here, kinematic_car and dynamic_car work."
    )
    (second,) = mistakes_in(tmp_path, SPACE.replace("goal.x", "control = dynamic_car\ngoal.x"))
    assert second.startswith("gap.cfg line 11 control: dynamic_car moves in the plane")


def test_a_file_that_names_half_of_space(tmp_path: Path) -> None:
    missing = mistakes_in(tmp_path, without(SPACE, "goal.axis.y", "start.z"))
    wanted = "In space, give start.x, start.y, start.z, start.theta, start.axis.x, start.axis.y"
    assert missing[0].startswith(f"gap.cfg: [problem] start.z is missing. {wanted}")
    assert missing[1].startswith("gap.cfg: [problem] goal.axis.y is missing. In space, give goal.x")


def test_an_axis_without_a_direction(tmp_path: Path) -> None:
    text = SPACE.replace("goal.theta = 0", "goal.theta = 1")
    (mistake,) = mistakes_in(tmp_path, text)
    assert mistake == "gap.cfg line 15 goal.axis.x: the axis is 0, 0, 0. 1, 0, 0 points along x."


def test_volumes_and_probabilities_the_wrong_way_round(tmp_path: Path) -> None:
    text = PLANE.replace("volume.max.y = 6", "volume.max.y = -7").replace("0.2", "2")
    assert mistakes_in(tmp_path, text) == [
        "gap.cfg line 15 volume.max.y: volume.min.y is -6 and volume.max.y -7. Put min below max.",
        "gap.cfg line 24 kpiece.goal_bias: 2 is no probability. Give a number from 0 to 1.",
    ]


def test_a_state_space_beside_control(tmp_path: Path) -> None:
    text = PLANE.replace("name = gap", "statespace = dubins\ncontrol = kinematic_car")
    (mistake,) = mistakes_in(tmp_path, text)
    assert mistake.startswith("gap.cfg line 3 statespace: it is for a body in the plane without")
    (mistake,) = mistakes_in(tmp_path, PLANE.replace("name = gap", "statespace = dubinssymmetric"))
    assert mistake.startswith("gap.cfg line 3 statespace: no state space is called")


def test_files_that_are_too_long(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"it has more than 10000 lines"):
        kinolab.load(problem_file(tmp_path, "\n" * 10_001))
    with pytest.raises(InputError, match=r"larger than 30 MB"):
        kinolab.load(problem_file(tmp_path, "#" * 30_000_001))


def test_of_very_many_mistakes_the_first_are_told(tmp_path: Path) -> None:
    found = mistakes_in(tmp_path, PLANE + "x\n" * 5000)
    assert len(found) == 101
    assert "may be more" in found[-1]


def test_a_robot_of_too_many_triangles_is_refused(tmp_path: Path) -> None:
    boxes = [((k, 0.0, 0.0), (k + 0.5, 1.0, 1.0)) for k in range(4200)]
    written(tmp_path, many_obj=obj(*boxes))
    (mistake,) = mistakes_in(tmp_path, PLANE.replace("bar.obj", "many.obj"))
    assert mistake.startswith("gap.cfg line 4 robot: many.obj has more than 50000 triangles.")


# --- plans ---


def gap_between(corners: np.ndarray) -> float:
    """Return the distance of a convex polygon (4, 2) from two walls at |x| < 0.25, |y| > 1."""
    points = np.concatenate(
        [corners[k] + s * (np.roll(corners, -1, 0)[k] - corners[k])
         for k in range(4) for s in np.linspace(0, 1, 50)[:, None]]
    ).reshape(-1, 2)  # fmt: skip
    away = np.maximum(np.abs(points) - [[0.25, 0.0]], 0.0)[:, 0]
    into = np.maximum(1.0 - np.abs(points[:, 1]), 0.0)
    return float(np.hypot(away, into).min())


def test_a_bar_goes_through_the_gap(tmp_path: Path) -> None:
    """It stands across at first, and can only pass lengthwise: the gap is 2 wide, as it is long."""
    problem = kinolab.load(problem_file(tmp_path), overrides=["planner.name=auto"])
    plan = problem.solve(seed=1, optimize=False)  # the search alone has to find the way
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert all(check.passed for check in plan.certificate.checks)
    states = plan.trajectory.x
    assert states[0] == pytest.approx([-4.0, 0.5, math.pi / 2])
    assert states[-1, :2] == pytest.approx([4.0, -0.5], abs=0.06)
    assert math.cos(states[-1, 2] + math.pi / 2) > math.cos(0.05)
    own = np.array([[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]])
    for x, y, theta in states:
        turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
        assert gap_between(own @ turn.T + [x, y]) > 0.0
