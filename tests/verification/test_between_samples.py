"""What happens in less room than lies between two samples is found all the same.

All motions are straight and even, x = v t, so that what must be found is known.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy

from kinolab.dynamics import Body, Force, Potential, Rate, Sphere, System, length, move, require
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.support import detail, failed, problem_of

WIDTHS = (0.3, 1e-2, 1e-4, 1e-6)  # [m]
PLACE, LENGTH, SPEED = 2.013, 4.0, 1.0  # [m], [m], [m/s]
x = length("x", -10, 10, speed=3.0)


def bump(width: float) -> sympy.Expr:
    """Return what is 1 at one place and nothing beside it."""
    return sympy.exp(-(((x - PLACE) / width) ** 2))


def lane(folder: Path, machine: System, world: str = "") -> PlanningTask:
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
    problem = lane(tmp_path, cart(requirement=room - bump(width)))
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
