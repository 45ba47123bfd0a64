"""The problem as OMPL sees it: attitudes, samples of the goal, and whether a step is free."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.problem import PlanningTask
from kinolab.search.ompl import OmplSetup
from kinolab.simulation import Propagator
from kinolab.world import CollisionChecker
from tests.support import OPEN, coin_after, problem_of

Array = NDArray[np.float64]

SPACING = 1e-3  # [m] of motion between two looks of the slow check
RESOLUTION = 0.01  # [m] within which a sweep may take what is near for what touches

SUBMARINE = """\
schema = 1
title = "A submarine near a sheet of glass"

[system]
name = "submarine"

[world]
bounds = { x = [-5, 5], y = [-5, 5], z = [-5, 5] }

[metric]
R = 0.7

[start]
x = -3.0

[goal]
x = 3.0
R = [0, 0, 1, 1]
tolerance = { x = 0.5, R = 0.2 }
"""

PLATE = """
[[world.obstacle]]
box = [0.001, 2.0, 2.0]
"""

MACHINES = """\
import sympy
from kinolab.dynamics import Body, Box, Force, Sphere, System, Torque
from kinolab.dynamics import length, move, orient, rotation

def thing(name, shape, rests=False):
    x, z = length("x", speed=100.0), length("z", speed=100.0)
    frame = move(x, 0, z)
    body = Body(name, frame, mass=1.0, shape=shape, touches_ground=rests)
    return System(name, bodies=[body], inputs=[Force("lift", on=body, along=frame.z, limit=99.0)])

def diver():
    return thing("diver", Sphere(0.1))

def hopper():
    return thing("hopper", Sphere(0.1), rests=True)

def dart():
    return thing("dart", Sphere(0.005))

def board():
    return thing("board", Box(0.4, 0.2, 0.02))

def bead():
    x = length("x", -0.9, 0.9, speed=9.0)
    wire = move(x, 0, 1.05 - sympy.sqrt(1 - x**2))  # its lowest point is 5 cm above the ground
    bead = Body("bead", wire, mass=1.0, shape=Sphere(0.1))
    return System("bead", bodies=[bead], inputs=[Force("push", on=bead, along=wire.x, limit=9.0)])

def twins():
    R, S = rotation("R", speed=9.0), rotation("S", speed=9.0)
    x = length("x", -5, 5, speed=2.0)
    frames = {"left": orient(R), "right": move(x) @ orient(S)}
    bodies = [Body(name, frame, mass=1.0, inertia=(0.3, 0.2, 0.1), shape=Sphere(0.1))
              for name, frame in frames.items()]
    turns = [Torque(f"turn_{body.name}", on=body, about=body.frame.x, limit=1.0) for body in bodies]
    return System("twins", bodies=bodies, inputs=turns)
"""

MADE = """\
schema = 1
title = "A machine made for a test"

[system]
file = "machines.py:{}"

[world]
bounds = {{ x = [-20, 20], z = [-20, 20] }}
ground = "plane"

[goal]
x = 0.5
"""


def made(folder: Path, name: str, *overrides: str, text: str = "") -> PlanningTask:
    """A problem with one of the machines above."""
    folder.joinpath("machines.py").write_text(MACHINES, encoding="utf-8")
    return problem_of(folder, MADE.format(name) + text, *overrides)


@pytest.fixture(scope="module")
def submarine(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("submarine"), SUBMARINE)


def states(problem: PlanningTask, count: int) -> Iterator[Array]:
    """Random states within the limits, attitudes uniform."""
    generator = np.random.default_rng(1900)
    lower, upper = problem.sampling_bounds.T
    for x in generator.uniform(lower, upper, (count, len(lower))):
        for first in problem.model.attitudes.values():
            x[first : first + 4] = Rotation.from_quat(generator.normal(size=4)).as_quat()
        yield x


# --- attitudes in OMPL's spaces ---


def test_attitudes_are_written_and_read_in_their_places(
    submarine: PlanningTask, tmp_path: Path
) -> None:
    twins = made(tmp_path, "twins", "world.ground='none'")
    assert sorted(twins.model.attitudes.values()) in ([0, 4], [0, 5], [1, 5])
    for problem in (submarine, twins):
        bridge = problem.to_ompl()
        state = bridge.space.allocState()
        for x in states(problem, 50):
            bridge.write(state, x.tolist())
            angles = problem.circular
            assert np.array(bridge.read(state))[~angles] == pytest.approx(x[~angles], abs=1e-15)


def test_a_quaternion_of_another_length_is_written_as_a_unit_one(submarine: PlanningTask) -> None:
    bridge = submarine.to_ompl()
    state = bridge.space.allocState()
    bridge.write(state, [0, 0, 0, 0, 0, -3.0, 4.0, 0, 0, 0, 0, 0, 0])
    assert bridge.read(state)[3:7] == pytest.approx([0, 0, -0.6, 0.8], abs=1e-15)


def test_the_distance_of_two_attitudes_is_their_angle_times_its_weight(
    submarine: PlanningTask,
) -> None:
    """OMPL takes the arc cosine of a product near 1, which loses half of the digits."""
    bridge = submarine.to_ompl()
    a, b = bridge.space.allocState(), bridge.space.allocState()
    for x, y in zip(states(submarine, 50), states(submarine, 100), strict=False):
        other = x.copy()
        other[3:7] = (Rotation.from_quat(x[3:7]) * Rotation.from_quat(y[3:7])).as_quat()
        bridge.write(a, x.tolist())
        for sign in (1, -1):
            other[3:7] *= sign
            bridge.write(b, other.tolist())
            angle = float(Rotation.from_quat(y[3:7]).magnitude())
            assert bridge.space.distance(a, b) == pytest.approx(0.7 * angle, abs=1e-8)


def test_the_other_entries_add_to_the_distance_of_attitudes(submarine: PlanningTask) -> None:
    """Half a turn weighs 0.7 pi; 2 m weigh 2; a metre per second weighs one over the limit."""
    bridge = submarine.to_ompl()
    a, b = bridge.space.allocState(), bridge.space.allocState()
    bridge.write(a, [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0])
    bridge.write(b, [2, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0])
    assert bridge.space.distance(a, b) == pytest.approx(0.7 * np.pi + 2.0 + 0.5, abs=1e-7)


@pytest.mark.parametrize("method", ["rk4", "euler"])
def test_a_state_that_is_reached_has_a_unit_quaternion(method: str, tmp_path: Path) -> None:
    """Euler's steps make a quaternion longer: by an eighth of the squared turn of each."""
    overrides = (f'integration.method="{method}"', "integration.step=0.2")
    bridge = problem_of(tmp_path, SUBMARINE, *overrides).to_ompl()
    information = bridge.space_information
    here, there = bridge.space.allocState(), bridge.space.allocState()
    control = information.getControlSpace().allocControl()
    control[0], control[1], control[2] = 60.0, 25.0, -25.0
    bridge.write(here, [0, 0, 0, 0.5, 0.5, -0.5, 0.5, 1, 1, 1, 0.9, 0.9, 0.9])
    for _ in range(20):
        information.propagate(here, control, 1, there)
        here, there = there, here
        assert np.linalg.norm(bridge.read(here)[3:7]) == pytest.approx(1.0, abs=4e-16)


# --- samples of the goal ---


@pytest.mark.parametrize("zoom", [1.0, 3.0, 1e6])
def test_samples_of_the_goal_reach_as_far_as_the_goal_region_scale(
    zoom: float, submarine: PlanningTask
) -> None:
    bridge = OmplSetup(submarine, goal_region_scale=zoom)
    region, state = bridge.problem_definition.getGoal(), bridge.space.allocState()
    rows = []
    for _ in range(300):
        region.sampleGoal(state)
        rows.append(bridge.read(state))
    x = np.array(rows)
    turns = (Rotation.from_quat(x[:, 3:7]).inv() * Rotation.from_euler("z", np.pi / 2)).magnitude()
    assert turns.max() <= min(0.2 * zoom, np.pi) + 1e-14  # [rad] rounding
    assert np.abs(x[:, 0] - 3.0).max() <= 0.5 * zoom + 1e-14
    assert x[:, 0].max() <= 5.0 + 1e-9  # the world ends there, but for the rounding allowed
    if zoom > 1:
        assert turns.max() > 0.2
        assert np.abs(x[:, 0] - 3.0).max() > 0.5


# --- whether a step is free ---


class Looks:
    """Asks a propagator about single steps."""

    def __init__(self, problem: PlanningTask) -> None:
        self._propagator = Propagator(problem)

    def accept(self, x: Array, u: Array, duration: float) -> bool:
        return self._propagator.touches_nothing(x.tolist(), u.tolist(), duration)


def along(problem: PlanningTask, x: Array, u: Array, duration: float) -> Array:
    """The states of a step so often that no point moves more than SPACING in between."""
    ends = np.array([x, problem.model.step(x, u, duration)])
    speed = 1.5 * float(problem.model.point_speed(ends, np.tile(u, (2, 1))).max())
    times = np.linspace(0.0, duration, int(np.ceil(speed * duration / SPACING)) + 2)
    if problem.system.name == "rolling_disk":
        return coin_after(x, u, times)  # in closed form
    return np.array([problem.model.step(x, u, t) for t in times])


def free(problem: PlanningTask, checker: CollisionChecker, x: Array) -> bool:
    """Whether all states touch nothing and keep the origins of bodies within the workspace."""
    table = problem.frames(x)  # (states, bodies, 12)
    for axis, (lower, upper) in problem.world.bounds.items():
        origins = table[:, :, 4 * "xyz".index(axis) + 3]
        if origins.min() < lower or origins.max() > upper:
            return False
    return not any(checker.collides(poses) for poses in table)


def judge_against_small_steps(problem: PlanningTask, steps: list[tuple[Array, Array]]) -> None:
    """Compare a sweep with looks SPACING apart: at the machine itself, and at a larger one.

    What is accepted touches nothing; what is rejected comes within RESOLUTION of something.
    """
    looks, exact, wide = Looks(problem), problem.checker(), problem.checker(margin=RESOLUTION)
    outcomes = []
    for x, u in steps:
        accepted = looks.accept(x, u, problem.step)
        way = along(problem, x, u, problem.step)
        if accepted:
            assert free(problem, exact, way), f"accepted, but not free: {x.tolist()}"
        else:
            assert not free(problem, wide, way), f"rejected for nothing: {x.tolist()}"
        outcomes.append(accepted)
    assert min(outcomes.count(True), outcomes.count(False)) > len(steps) / 10


def steps_near_something(
    problem: PlanningTask, count: int, reach: float
) -> list[tuple[Array, Array]]:
    """Random states that are free and have less room than ``reach`` in [m], and random inputs."""
    generator, checker, found = np.random.default_rng(7), problem.checker(), []
    for x in states(problem, 200 * count):
        if 0.0 < checker.clearance(*problem.placement(x)) < reach:
            found.append((x, generator.uniform(*problem.model.control_bounds.T)))
        if len(found) == count:
            return found
    raise AssertionError("too few states are near something")


def test_a_coin_in_the_maze_is_judged_as_by_small_steps() -> None:
    """Its motion is known in closed form."""
    problem = kinolab.load("rolling_disk_maze")
    judge_against_small_steps(problem, steps_near_something(problem, 500, 0.2))


def test_a_robot_between_boxes_is_judged_as_by_small_steps(tmp_path: Path) -> None:
    boxes = "".join(
        f"\n[[world.obstacle]]\nbox = [0.3, {width}, 0.2]\nposition = [{x}, {y}, {z}]\n"
        f"rpy = [0.0, {tilt}, {yaw}]\n"
        for x, y, z, width, tilt, yaw in [
            (1.0, 0.5, 0.1, 0.05, 0.0, 0.4),
            (-1.0, 0.3, 0.15, 1.0, 0.3, -0.9),
            (0.2, -1.0, 0.32, 0.6, 0.0, 0.0),  # lower than the robot is high
        ]
    )
    text = OPEN.replace("rolling_disk", "diff_drive").replace("[-5, 5]", "[-2, 2]")
    problem = problem_of(tmp_path, text + boxes, "integration.step=0.1")
    judge_against_small_steps(problem, steps_near_something(problem, 300, 0.04))


def test_a_submarine_near_a_sheet_of_glass_is_judged_as_by_small_steps(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, SUBMARINE + PLATE, "integration.step=0.1")
    judge_against_small_steps(problem, steps_near_something(problem, 100, 0.2))


def test_nothing_flies_through_a_plate_a_millimetre_thick(tmp_path: Path) -> None:
    """The dart passes a plate of 1 m height if its radius, 5 mm, fits above it."""
    plate = "\n[[world.obstacle]]\nbox = [0.001, 1.0, 1.0]\nposition = [0.0, 0.0, 0.5]\n"
    overrides = ("world.ground='none'", "start={ x = -3, z = 0.5 }")
    looks = Looks(made(tmp_path, "dart", *overrides, text=plate))
    generator = np.random.default_rng(0)
    for speed in (1.0, 10.0, 99.0):
        for height in [*generator.uniform(0.0, 1.0, 50), 1.004999]:
            x = np.array([-speed * generator.uniform(0.001, 0.049) - 0.006, height, speed, 0.0])
            assert not looks.accept(x, np.zeros(1), 0.05)
        for height in (1.016, 1.5):
            x = np.array([-speed * generator.uniform(0.001, 0.049), height, speed, 0.0])
            assert looks.accept(x, np.zeros(1), 0.05)


# --- the ground ---


def dips(radius: float) -> Iterator[tuple[Array, float, float, float]]:
    """Ways down and up again: state, lift, duration, and the lowest point of a ball in [m].

    At z + v t + a t^2 / 2 a ball is lowest after -v / a, or at an end. All masses are 1 kg.
    """
    generator = np.random.default_rng(3)
    for _ in range(400):
        z, duration = generator.uniform(radius + 0.02, 1.0), generator.uniform(0.02, 1.0)
        lift = generator.uniform(0.0, 20.0)
        v = -lift * duration / 2 + generator.uniform(-0.3, 0.3)
        t = float(np.clip(-v / lift, 0.0, duration))
        yield np.array([0.0, z, 0.0, v]), lift, duration, z + v * t + lift * t**2 / 2 - radius


def test_a_ball_that_dips_into_the_ground_within_a_step_is_rejected(tmp_path: Path) -> None:
    looks, outcomes = Looks(made(tmp_path, "diver", "start.z=1")), []
    for x, lift, duration, lowest in dips(0.1):
        accepted = looks.accept(x, np.array([lift]), duration)
        assert lowest > 0.0 if accepted else lowest < RESOLUTION
        outcomes.append(accepted)
    assert min(outcomes.count(True), outcomes.count(False)) > 100


def test_a_foot_that_dips_into_the_ground_within_a_step_is_rejected(tmp_path: Path) -> None:
    """It may stand on the ground; looks a resolution apart see all that is deeper than that."""
    looks = Looks(made(tmp_path, "hopper", "start.z=1"))
    for x, lift, duration, lowest in dips(0.1):
        accepted = looks.accept(x, np.array([lift]), duration)
        assert lowest > -RESOLUTION if accepted else lowest < 0.0


def test_a_bead_on_a_wire_that_leads_through_the_ground_is_rejected(tmp_path: Path) -> None:
    """Where the wire has no points its height is not a number, which says nothing about it."""
    looks = Looks(made(tmp_path, "bead", "world.bounds={}", "start.x=-0.7"))
    for x in (-0.45, -0.5, -0.6):
        assert not looks.accept(np.array([x, -2 * x / 0.2]), np.zeros(1), 0.2)
        assert looks.accept(np.array([x, -0.1]), np.zeros(1), 0.2)


@pytest.mark.parametrize("speed", [0.1, 3.0, 90.0])
def test_a_board_a_centimetre_above_the_ground_glides_at_any_speed(
    speed: float, tmp_path: Path
) -> None:
    """Its lower side is 1 cm below its middle."""
    looks = Looks(made(tmp_path, "board", "start.z=0.02"))
    assert looks.accept(np.array([0.0, 0.02, speed, 0.0]), np.zeros(1), 0.1)
    assert not looks.accept(np.array([0.0, 0.02, speed, -0.5]), np.zeros(1), 0.1)
    assert not looks.accept(np.array([0.0, 0.009, speed, 0.0]), np.zeros(1), 0.1)


def test_a_snakeboard_in_the_open_is_never_rejected_for_the_ground(tmp_path: Path) -> None:
    text = OPEN.replace("rolling_disk", "snakeboard")
    problem = problem_of(tmp_path, text, "integration.step=0.1")
    looks, generator = Looks(problem), np.random.default_rng(0)
    for x in states(problem, 300):
        x[:2] /= 2  # far from the world's edge: 0.1 s at 1.6 m/s lead 0.16 m away
        u = generator.uniform(*problem.model.control_bounds.T)
        assert looks.accept(x, u, problem.step)


# --- limits within a step ---


def pendulum(folder: Path, text: str) -> PlanningTask:
    """A pendulum whose rod leads along (cos theta, sin theta)."""
    head = 'schema = 1\ntitle = "A pendulum"\n[system]\nname = "pendulum"\n'
    return problem_of(folder, f"{head}[goal]\ntheta = 3.14\n{text}")


def swings(count: int) -> list[Array]:
    """Fast states up to 0.4 rad before the rod points to -y, none in what is forbidden there."""
    generator = np.random.default_rng(0)
    turned, rates = generator.uniform(0.06, 0.4, count), generator.uniform(2.0, 9.0, count)
    return list(np.column_stack([-np.pi / 2 - turned, rates]))


def accepted(problem: PlanningTask, start: list[Array]) -> Iterator[Array]:
    """The ways, states (n, 2), of the steps from given states that planners may use."""
    bridge = problem.to_ompl()
    information = bridge.space_information
    here, there = bridge.space.allocState(), bridge.space.allocState()
    control = information.getControlSpace().allocControl()
    control[0] = 0.0
    for x in start:
        bridge.write(here, x.tolist())
        information.propagate(here, control, 1, there)
        if information.isValid(there):
            yield along(problem, x, np.zeros(1), problem.step)


def test_a_body_does_not_leave_the_workspace_within_a_step(tmp_path: Path) -> None:
    """Looks 1 cm apart, on a circle of 1 m, overlook 0.005^2 / 2 = 1.25e-5 m at most."""
    problem = pendulum(tmp_path, "[world]\nbounds = { y = [-0.999, 2.0] }\n")
    ways = list(accepted(problem, swings(200)))
    assert len(ways) > 20
    assert min(np.sin(way[:, 0]).min() for way in ways) > -0.999 - 1.25e-5


def test_an_axis_does_not_cross_a_forbidden_cone_within_a_step(tmp_path: Path) -> None:
    """The rod turns up to 0.45 rad in a step; looks 0.01 rad apart overlook half of that."""
    cone = '[[keep_out]]\nbody = "bob"\naxis = "x"\ndirection = [0, -1, 0]\nhalf_angle = 0.05\n'
    ways = list(accepted(pendulum(tmp_path, cone), swings(200)))
    assert len(ways) > 20
    assert min(np.abs(way[:, 0] + np.pi / 2).min() for way in ways) > 0.05 - 0.005


# --- checkers with another margin ---


CRANE = """\
schema = 1
title = "A crane between two posts"

[system]
name = "crane"

[world]
bounds = { x = [0, 10], y = [0, 14] }
ground = "plane"

[[world.obstacle]]
box = [1.0, 1.0, 6.0]
position = [3.0, 4.0, 3.0]

[[world.obstacle]]
cylinder = [0.5, 5.0]
position = [7.0, 9.0, 2.5]
"""


@pytest.fixture(scope="module")
def crowded(tmp_path_factory: pytest.TempPathFactory) -> list[PlanningTask]:
    """Meshes and solids around a coin, and around a crane with its rope."""
    crane = problem_of(tmp_path_factory.mktemp("crane"), CRANE)
    return [kinolab.load("rolling_disk_maze"), crane]


@pytest.mark.parametrize("ground", [True, False])
@pytest.mark.parametrize("margin", [0.0, 0.005, 0.3])
def test_an_inflated_checker_judges_like_a_new_one(
    margin: float, ground: bool, crowded: list[PlanningTask]
) -> None:
    for problem in crowded:
        twin = problem.checker(margin=0.1).inflated(margin, ground=ground)
        world = replace(problem.world, ground=ground)
        parts = {"cables": problem.cables, "self_pairs": problem.system.collisions}
        new = CollisionChecker(problem.bodies, world, margin=margin, **parts)
        for x in states(problem, 200):
            place = problem.placement(x)
            assert twin.collides(*place) == new.collides(*place)
            assert twin.contacts(*place) == new.contacts(*place)
            assert twin.clearance(*place) == new.clearance(*place)


def test_a_checker_and_its_inflated_twin_do_not_disturb_each_other(
    crowded: list[PlanningTask],
) -> None:
    for problem in crowded:
        checker, alone = (problem.checker(margin=0.1) for _ in range(2))
        twin = checker.inflated(0.5, ground=False)
        for x in states(problem, 200):
            place = problem.placement(x)
            twin.collides(*place)
            assert checker.collides(*place) == alone.collides(*place)
            twin.collides(*place)
            assert checker.clearance(*place) == alone.clearance(*place)
