"""What happens in less room than lies between two samples is found all the same.

All motions are straight and even, x = v t, so that what must be found is known. Widths and sizes
are parameters, so that a machine is compiled once for all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy

from kinolab import Problem
from kinolab.dynamics import (
    Body,
    Force,
    Potential,
    Rate,
    Sphere,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    require,
    rot_z,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.problem.goal import KeepOutCone
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.support import detail, failed, problem_of

WIDTHS = (0.3, 1e-2, 1e-4, 1e-6)  # [m]
PLACE, LENGTH, SPEED = 2.013, 4.0, 1.0  # [m], [m], [m/s]
x, a = length("x", -10, 10, speed=3.0), angle("a", -50, 50, speed=9.0)


def bump(width: float) -> sympy.Expr:
    """Return what is 1 at one place and nothing beside it."""
    return sympy.exp(-(((x - PLACE) / parameter("w", width)) ** 2))


def lane(folder: Path, machine: System, world: str = "") -> Problem:
    """Return a machine that moves from x = 0 to 4 m."""
    (folder / "own.json").write_text(machine_to_json(machine))
    text = (
        f'schema = 1\ntitle = "A lane"\n[system]\nfile = "own.json"\n[goal]\nx = {LENGTH}\n{world}'
    )
    speed = () if machine.bodies[0].mass == 0 else ("start.x_dot=1.0",)
    return problem_of(folder, text, "goal.tolerance=0.1", *speed)


def even(problem: PlanningTask) -> Trajectory:
    """Return the even motion in a single row."""
    names = problem.model.state_names, problem.model.control_names
    states = np.array([[0.0, SPEED], [LENGTH, SPEED]])[:, : len(names[0])]
    held = np.array([[SPEED if len(names[0]) == 1 else 0.0]])
    return Trajectory(np.array([0.0, LENGTH / SPEED]), states, held, *names)


def cart(y: sympy.Expr | float = 0.0, requirement: sympy.Expr | None = None) -> System:
    return System(
        "cart",
        bodies=[Body("cart", move(x, y, 0), shape=Sphere(0.05))],
        inputs=[Rate("v", on=x, limit=2.0)],
        requirements=[] if requirement is None else [require(requirement, "room")],
    )


@pytest.mark.parametrize("width", WIDTHS)
def test_a_body_that_jumps_aside_does_not_pass_a_wall(width: float, tmp_path: Path) -> None:
    wall = "[[world.obstacle]]\nbox = [6.0, 0.1, 1.0]\nposition = [2.0, 0.5, 0.0]\n"
    problem = lane(tmp_path, cart(bump(width)), wall)
    assert "collision" in failed(verify(problem, even(problem)))


def test_a_body_that_does_not_jump_passes(tmp_path: Path) -> None:
    wall = "[[world.obstacle]]\nbox = [6.0, 0.1, 1.0]\nposition = [2.0, 0.5, 0.0]\n"
    problem = lane(tmp_path, cart(), wall)
    certificate = verify(problem, even(problem))
    assert certificate.passed, str(certificate)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(("room", "passes"), [(0.9, False), (1.1, True)])
def test_a_requirement_that_is_broken_in_an_instant_is_not_met(
    width: float, room: float, passes: bool, tmp_path: Path
) -> None:
    problem = lane(tmp_path, cart(requirement=parameter("room", room) - bump(width)))
    certificate = verify(problem, even(problem))
    assert failed(certificate) == (set() if passes else {"requirements"})
    if not passes:
        assert "room" in detail(certificate, "requirements")
        assert "at t = 2.0" in detail(certificate, "requirements")


@pytest.mark.parametrize("width", [0.3, 0.05, 0.01, 0.003])
def test_a_hill_that_is_too_high_is_not_stepped_over(width: float, tmp_path: Path) -> None:
    """The cart has 0.5 J, and the hill is 1 J high; in one step it would be passed by."""
    sledge = Body("cart", move(x, 0, 0), mass=1.0, shape=Sphere(0.05))
    machine = System(
        "cart",
        bodies=[sledge],
        inputs=[Force("push", on=sledge, along=sledge.frame.x, limit=1.0)],
        efforts=[Potential(bump(width))],
    )
    problem = lane(tmp_path, machine)
    assert "dynamics" in failed(verify(problem, even(problem)))


def turning(folder: Path) -> PlanningTask:
    """Return a ball that turns about its own centre, so that no point of it moves."""
    ball = Body("ball", rot_z(a), mass=1.0, inertia=(1.0, 1.0, 1.0), shape=Sphere(0.1))
    machine = System(
        "ball",
        bodies=[ball],
        inputs=[Torque("turn", on=ball, about=ball.frame.z, limit=5.0)],
    )
    (folder / "own.json").write_text(machine_to_json(machine))
    text = 'schema = 1\ntitle = "A ball"\n[system]\nfile = "own.json"\n[goal]\na_dot = 1.0\n'
    return problem_of(folder, text, "goal.tolerance=9.0", "start.a_dot=1.0")


def turned(problem: PlanningTask, torque: float, seconds: float) -> Trajectory:
    """Return the ball's motion under a torque, its inertia being 1 kg m^2, in a single row."""
    end = [seconds + torque * seconds**2 / 2, 1.0 + torque * seconds]
    states = np.array([[0.0, 1.0], end])
    names = problem.model.state_names, problem.model.control_names
    return Trajectory(np.array([0.0, seconds]), states, np.array([[torque]]), *names)


@pytest.mark.parametrize("peak", [3.005, 3.029, 3.2])
@pytest.mark.parametrize("after", [0.2, 0.5, 1.0])
def test_an_angle_that_passes_its_limit_where_no_point_moves_is_seen(
    peak: float, after: float, tmp_path: Path
) -> None:
    """It turns by s - s^2 / (4 peak), at most by peak."""
    problem = turning(tmp_path)
    torque = -1.0 / (2 * peak)
    problem = replace(problem, bounds=np.array([[-3.0, 3.0], [-9.0, 9.0]]))
    assert "limits" in failed(verify(problem, turned(problem, torque, (1 + after) * 2 * peak)))


@pytest.mark.parametrize("half_angle", [0.8, 0.1, 0.01])
def test_an_axis_that_sweeps_through_a_cone_is_seen(half_angle: float, tmp_path: Path) -> None:
    cone = KeepOutCone(0, (1.0, 0.0, 0.0), (math.cos(2), math.sin(2), 0.0), half_angle)
    problem = turning(tmp_path)
    assert verify(problem, turned(problem, 0.0, 5.0)).passed
    certificate = verify(replace(problem, keep_outs=(cone,)), turned(problem, 0.0, 5.0))
    assert failed(certificate) == {"limits"}


@pytest.mark.parametrize("seconds", [1.5, 6.0])
@pytest.mark.parametrize("about", [(0.6, 0.0, 0.8), (-0.6, 0.64, 0.48), (0.64, -0.6, 0.48)])
def test_a_cone_that_an_axis_passes_beside_is_not_in_its_way(
    about: tuple[float, float, float], seconds: float, tmp_path: Path
) -> None:
    angles = np.linspace(0.0, seconds, 10_001)
    nearest = float(np.arccos(about[0] * np.cos(angles) + about[1] * np.sin(angles)).min())
    problem = turning(tmp_path)
    for half_angle, passes in ((nearest - 0.02, True), (nearest + 0.02, False)):
        cone = KeepOutCone(0, (1.0, 0.0, 0.0), about, half_angle)
        motion = turned(problem, 0.0, seconds)
        assert verify(replace(problem, keep_outs=(cone,)), motion).passed == passes


@pytest.mark.parametrize("width", [0.1, 1e-3, 1e-5])
def test_a_body_that_jumps_by_a_sign_does_not_pass_a_wall(width: float, tmp_path: Path) -> None:
    aside = (sympy.sign(x - PLACE) - sympy.sign(x - PLACE - parameter("w", width))) / 4
    wall = "[[world.obstacle]]\nbox = [6.0, 0.1, 1.0]\nposition = [2.0, 0.5, 0.0]\n"
    problem = lane(tmp_path, cart(aside), wall)
    assert "collision" in failed(verify(problem, even(problem)))


@pytest.mark.parametrize("jump", [sympy.sign(x - PLACE), abs(x - PLACE) / (x - PLACE)])
def test_a_body_that_is_now_here_and_now_there_is_refused(jump: sympy.Expr, tmp_path: Path) -> None:
    wall = "[[world.obstacle]]\nbox = [6.0, 0.1, 1.0]\nposition = [2.0, 0.5, 0.0]\n"
    problem = lane(tmp_path, cart(jump), wall)
    assert "collision" in failed(verify(problem, even(problem)))


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_a_requirement_without_a_value_in_an_instant_is_not_met(
    width: float, tmp_path: Path
) -> None:
    problem = lane(tmp_path, cart(requirement=sympy.sqrt(0.9 - bump(width))))
    assert failed(verify(problem, even(problem))) == {"requirements"}


def test_what_a_requirement_is_at_the_start_hides_nothing_later(tmp_path: Path) -> None:
    """It is 1000 there."""
    problem = lane(tmp_path, cart(requirement=1 / (x + 1e-3) + 0.3 - bump(1e-4)))
    assert failed(verify(problem, even(problem))) == {"requirements"}


def test_a_requirement_of_a_plan_without_a_step_counts(tmp_path: Path) -> None:
    for room, passes in ((x - 1.0, False), (x + 1.0, True)):
        problem = lane(tmp_path, cart(requirement=room))
        names = problem.model.state_names, problem.model.control_names
        still = Trajectory(np.zeros(1), np.zeros((1, 1)), np.zeros((0, 1)), *names)
        assert ("requirements" not in failed(verify(problem, still))) == passes


@pytest.mark.parametrize(
    "room",
    [
        1 - (x - 2) ** 2 / 4,  # nothing at both ends
        (x - 2) ** 4 - 2 * (x - 2) ** 2 + 1,  # nothing at two places
        sympy.sqrt((x - 2) ** 2),
        1.1 - sympy.sin(x - PLACE) / (x - PLACE),  # 0 / 0 at a place
    ],
)
def test_a_requirement_that_is_just_met_is_met(room: sympy.Expr, tmp_path: Path) -> None:
    problem = lane(tmp_path, cart(requirement=room))
    certificate = verify(problem, even(problem))
    assert certificate.passed, str(certificate)


def notch(width: float) -> sympy.Expr:
    """Return what is 1 at one place and nothing farther from it than a width."""
    return sympy.Max(0, 1 - abs(x - PLACE) / width)


def smaller(one: sympy.Expr, other: sympy.Expr) -> sympy.Expr:
    return -sympy.Max(-one, -other)


# What is 1 at the place, and at most 0.4 elsewhere or farther from it than a few widths.
NESTED: dict[str, Callable[[sympy.Expr], sympy.Expr]] = {
    "max": notch,
    "min": lambda w: smaller(notch(2 * w), sympy.Max(0, 1 + (x - PLACE) / w)),
    "abs": lambda w: abs(abs(smaller(abs(x - PLACE) / w, 1)) - 1),
    "square": lambda w: sympy.Max(0, 1 - ((x - PLACE) / w) ** 2),
    "power": lambda w: notch(w) ** 3,
    "product": lambda w: notch(w) * notch(2 * w),
    "two sides": lambda w: sympy.Max(0, (PLACE + w - x) * (x - PLACE + w) / w**2),
    "exp": lambda w: sympy.exp(-abs(x - PLACE) / w),
    "exp of max": lambda w: sympy.exp(notch(w) * sympy.log(3.0)) / 2 - 0.5,
    "sign": lambda w: (sympy.sign(x - PLACE + w) - sympy.sign(x - PLACE - w)) / 2,
    "quotient": lambda w: 1 / (1 + ((x - PLACE) / w) ** 2),
    "root": lambda w: 1 - sympy.sqrt(smaller(1, abs(x - PLACE) / w)),
}


@pytest.fixture(scope="module")
def nested(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Problem]:
    """Return lanes by the kind of their requirement, whose width and room are parameters."""
    narrow, room = parameter("w", 1.0), parameter("room", 1.0)

    @cache
    def made(kind: str) -> Problem:
        machine = cart(requirement=room - NESTED[kind](narrow))
        return lane(tmp_path_factory.mktemp("lane"), machine)

    return made


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("kind", NESTED)
@pytest.mark.parametrize(("room", "passes"), [(0.5, False), (1.0, True), (1.01, True)])
def test_a_requirement_of_nested_terms_is_met_or_not(
    kind: str, width: float, room: float, passes: bool, nested: Callable[[str], Problem]
) -> None:
    """It is short by 0.5 at the place, or just met there, whatever its terms are elsewhere."""
    problem = nested(kind).replace(**{"system.parameters": {"w": width, "room": room}})
    certificate = verify(problem, even(problem))
    assert failed(certificate) == (set() if passes else {"requirements"})


@pytest.mark.parametrize("steep", [1e2, 1e5, 1e9])
@pytest.mark.parametrize(
    "shape", [abs, lambda d: d**2, lambda d: sympy.Max(d, -d), lambda d: d * sympy.sign(d)]
)
def test_large_terms_elsewhere_excuse_nothing_where_they_vanish(
    steep: float, shape: Callable[[sympy.Expr], sympy.Expr], tmp_path: Path
) -> None:
    """It is -1 at the place, and very large where the motion begins and ends."""
    problem = lane(tmp_path, cart(requirement=shape(parameter("steep", steep) * (x - PLACE)) - 1))
    assert failed(verify(problem, even(problem))) == {"requirements"}


@pytest.mark.parametrize("steep", [1e2, 1e4, 1e6])
def test_a_root_of_what_is_large_elsewhere_has_no_value_where_that_is_negative(
    steep: float, tmp_path: Path
) -> None:
    problem = lane(
        tmp_path, cart(requirement=sympy.sqrt(parameter("steep", steep) * abs(x - PLACE) - 1) + 1)
    )
    assert failed(verify(problem, even(problem))) == {"requirements"}


@pytest.mark.parametrize(("start", "apart"), [(0.0, 1.0), (-2.0, 1.0), (-2.0, 0.0), (-1.7, 0.0)])
def test_two_that_keep_their_distance_keep_it(start: float, apart: float, tmp_path: Path) -> None:
    """Over 4 m: the two places cancel, and their intervals do not, even where both are nothing."""
    y = length("y", -10, 10, speed=3.0)
    machine = System(
        "pair",
        bodies=[Body("one", move(x, 0, 0)), Body("other", move(y, 1, 0))],
        inputs=[Rate("v", on=x, limit=2.0), Rate("w", on=y, limit=2.0)],
        requirements=[require(y - x - apart, "distance")],
    )
    (tmp_path / "own.json").write_text(machine_to_json(machine))
    text = 'schema = 1\ntitle = "A pair"\n[system]\nfile = "own.json"\n[goal]\nx = 2.0\n'
    problem = problem_of(
        tmp_path, text, f"start.x={start}", f"start.y={start + apart}", "goal.tolerance=9.0"
    )
    names = problem.model.state_names, problem.model.control_names
    states = start + np.array([[0.0, apart], [4.0, 4.0 + apart]])
    certificate = verify(
        problem, Trajectory(np.array([0.0, 4.0]), states, np.array([[1.0, 1.0]]), *names)
    )
    assert certificate.passed, str(certificate)


def test_a_way_of_kilometres_is_verified(tmp_path: Path) -> None:
    far = length("x", -1e5, 1e5, speed=200.0)
    machine = System(
        "train",
        bodies=[Body("train", move(far, 0, 0), shape=Sphere(1.0))],
        inputs=[Rate("v", on=far, limit=200.0)],
    )
    (tmp_path / "own.json").write_text(machine_to_json(machine))
    text = 'schema = 1\ntitle = "A line"\n[system]\nfile = "own.json"\n[goal]\nx = 25000.0\n'
    problem = problem_of(tmp_path, text)
    names = problem.model.state_names, problem.model.control_names
    t = np.array([0.0, 100.0, 250.0])
    certificate = verify(problem, Trajectory(t, 100 * t[:, None], np.full((2, 1), 100.0), *names))
    assert certificate.passed, str(certificate)
