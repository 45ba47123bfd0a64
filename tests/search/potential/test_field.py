"""The whole potential: its forces are its slope, and what it is made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask
from kinolab.search.potential.field import Field, Repulsion, StraightLinePotential
from kinolab.search.potential.field_setup import navigation_field, plain_field
from kinolab.search.potential.pullback import generalised_force, point_jacobians, velocity_columns
from kinolab.simulation import Propagator
from tests.support import OPEN, WALL, problem_of

Array = NDArray[np.float64]


def slope_along_velocities(field: Field, x: Array, h: float) -> Array:
    """Differences of the potential along each independent velocity."""
    columns = velocity_columns(field.problem.model, x)[0].T
    ahead, behind = np.tile(x, (2, len(columns), 1))
    ahead[:, : columns.shape[1]] += h * columns
    behind[:, : columns.shape[1]] -= h * columns
    difference: Array = (field.potential(ahead) - field.potential(behind)) / (2 * h)
    return difference


def pulled_back(field: Field, x: Array) -> Array:
    forces = field.forces(x)
    jacobians = point_jacobians(field.problem.model, x, [(f.body, f.at) for f in forces])
    return generalised_force(jacobians, forces)


def around(problem: PlanningTask, x: Array, seed: int, spread: float) -> Array:
    generator = np.random.default_rng(seed)
    moved = x.copy()
    lengths = [i for i, name in enumerate(problem.model.state_names) if name in "xyzl"]
    moved[lengths] += generator.uniform(-spread, spread, len(lengths))
    return problem.model.project(moved)


@pytest.mark.parametrize("name", ["diffdrive_warehouse", "crane_factory", "submarine_corridor"])
@pytest.mark.parametrize("seed", range(3))
def test_forces_pulled_back_are_minus_the_slope_of_the_plain_potential(
    name: str, seed: int
) -> None:
    problem = kinolab.load(name)
    field = plain_field(problem, Repulsion(0.0, 0.3))
    x = around(problem, problem.start, seed, 0.5)
    slope = slope_along_velocities(field, x, 1e-5)
    assert pulled_back(field, x) == pytest.approx(-slope, abs=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_forces_of_navigation_are_minus_its_slope(seed: int) -> None:
    """Straight lines between corners of cells: h must stay within one, which 1e-6 m does."""
    problem = kinolab.load("diffdrive_warehouse")
    field = navigation_field(
        Propagator(problem),
        Repulsion(0.0, 0.3),
        resolution=0.3,
        grid_memory=16.0,
        clearance_cost_radius=0.5,
        stop=lambda: False,
    )
    assert field is not None
    x = around(problem, problem.start, seed, 0.4)
    assert pulled_back(field, x) == pytest.approx(-slope_along_velocities(field, x, 1e-6), abs=1e-6)


def pushed(folder: Path, gap: float, heading: float) -> tuple[Field, Array]:
    """A coin before a wall whose face is at x = 2.95, and a field that only pushes."""
    where = (f"start.x={2.95 - 0.25 - gap}", "start.y=0.3", f"start.psi={heading}")
    problem = problem_of(folder, OPEN + WALL, *where)

    def nothing(states: Array, _: Array) -> Array:
        return np.zeros(len(states))

    field = Field(problem, [], Repulsion(0.01, 0.3))
    field.attraction = nothing  # type: ignore[method-assign]
    return field, problem.start


@pytest.mark.parametrize("gap", [0.05, 0.1, 0.2])
def test_a_push_is_as_high_as_the_gap_says(gap: float, tmp_path: Path) -> None:
    """Heading for the wall, the coin's rim is 0.25 m ahead of its centre."""
    field, x = pushed(tmp_path, gap, 0.0)
    assert field.potential(x[None])[0] == pytest.approx(0.005 * (1 / gap - 1 / 0.3) ** 2, rel=1e-3)


@pytest.mark.parametrize("gap", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("heading", [0.3, -0.7, 1.2])
def test_a_push_pulled_back_is_minus_the_slope_of_its_potential(
    heading: float, gap: float, tmp_path: Path
) -> None:
    """Not head on: there the coin's rim is as near on both faces, and the potential has a kink."""
    field, x = pushed(tmp_path, gap, heading)
    slope = slope_along_velocities(field, x, 1e-4)
    # FCL measures to 1e-6 m, which over 2e-4 m is 1 % of a slope.
    assert pulled_back(field, x) == pytest.approx(-slope, rel=0.02, abs=0.02)


def test_touching_is_infinitely_high(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN + WALL)
    x = problem.start.copy()
    x[0] = 3.0
    assert plain_field(problem, Repulsion(1e-3, 0.3)).potential(x[None])[0] == np.inf


def test_without_a_push_contact_is_left_to_the_judge_of_steps(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN + WALL)
    x = problem.start.copy()
    x[0] = 3.0
    assert np.isfinite(plain_field(problem, Repulsion(0.0, 0.3)).potential(x[None])[0])


def test_where_the_goal_names_no_place_its_errors_are_the_potential(tmp_path: Path) -> None:
    text = OPEN.replace("x = 0.0\ny = 0.0\n", "phi_dot = 1.0\n")
    problem = problem_of(tmp_path, text)
    field = plain_field(problem, Repulsion(1e-3, 0.3))
    assert field.pulls == ()
    assert field.potential(problem.start[None])[0] == pytest.approx(1.0)
    assert problem.solve(planner="potential_field", max_iterations=500).status == "solved"


def test_a_straight_pull_has_slope_1_and_fades_at_the_goal() -> None:
    pull = StraightLinePotential(np.array([1.0, 2.0, 3.0]), rounding=0.1)
    generator, h = np.random.default_rng(0), 1e-6
    away = generator.normal(size=(50, 3))
    away *= (generator.uniform(0.01, 3, 50) / np.linalg.norm(away, axis=1))[:, None]
    points = pull.goal + away
    values, slopes = pull(points)
    for axis in range(3):
        step = h * np.eye(3)[axis]
        numeric = (pull(points + step)[0] - pull(points - step)[0]) / (2 * h)
        assert slopes[:, axis] == pytest.approx(numeric, abs=1e-6)
    distance = np.linalg.norm(away, axis=1)
    length = np.linalg.norm(slopes, axis=1)
    assert length == pytest.approx(np.minimum(distance / 0.1, 1.0), abs=1e-9)
    assert values == pytest.approx(np.where(distance < 0.1, 5 * distance**2, distance - 0.05))
    assert pull(pull.goal[None])[0][0] == 0.0
