"""Cars of bounded curvature take the curves of Dubins, Reeds and Shepp, and chains round walls."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Rate,
    System,
    angle,
    length,
    move,
    rate,
    rot_z,
    velocity,
    zero,
)
from kinolab.steering.bounded_curvature import curvature_car
from tests.oracles import vehicles as oracle
from tests.scenario.omplapp.test_problem_files import PLANE, problem_file

RADIUS, PACE = 0.8, 1.5  # [m], [m/s]
GOAL = {"x": 2.0, "y": -1.0, "psi": 2.5}
WIDE = {"bounds": {"x": [-9.0, 9.0], "y": [-9.0, 9.0]}}


def car(back: float, *, mirrored: bool = False) -> System:
    """One whose curvature is an input; mirrored, its heading is measured from y clockwise."""
    x, y, psi = length("x"), length("y"), angle("psi")
    frame = move(x, y) @ (rot_z(math.pi / 2 - psi) if mirrored else rot_z(psi))
    V, bend = velocity(frame), Control("bend", limit=1 / RADIUS, unit="1/m")
    return System(
        "any_name",
        bodies=[Body("hull", frame, shape=Box(0.4, 0.2, 0.2))],
        constraints=[zero(V.y, "no slip"), zero(rate(psi) - bend.symbol * V.x, "steered")],
        inputs=[Rate("speed", on=V.x, limit=(-back, PACE)), bend],
    )


def load(machine: System, **changes: Any) -> kinolab.Problem:
    return kinolab.load(
        {"system": machine, "goal": {**GOAL, "tolerance": 0.01}, "world": WIDE, **changes}
    )


@pytest.mark.parametrize(
    ("back", "shortest"), [(0.0, oracle.dubins_length), (PACE, oracle.reeds_shepp_length)]
)
@pytest.mark.parametrize("seed", range(4))
def test_in_the_open_a_car_takes_the_shortest_of_all_curves(
    back: float, shortest: Any, seed: int
) -> None:
    """As long as an oracle says, which is independent of OMPL; no seed of planning matters."""
    x, y, psi = np.random.default_rng(seed).uniform(-3, 3, 3).tolist()
    problem = load(car(back), goal={"x": x, "y": y, "psi": psi, "tolerance": 0.01})
    plan = problem.solve(seed=seed, improve=0)
    least = shortest((0.0, 0.0, 0.0), (x, y, psi), RADIUS)
    assert plan.status == "solved"
    assert plan.cost == pytest.approx(least / PACE, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2])
def test_round_a_wall_a_car_goes_along_a_chain_of_curves(seed: int) -> None:
    """No shorter than in the open, and not much longer than the way round the wall's end."""
    wall = {"box": [0.1, 3.0, 1.0], "position": [1.0, 0.0, 0.0]}
    problem = load(car(PACE), world={**WIDE, "obstacle": [wall]})
    plan = problem.solve(seed=seed, improve=0)
    assert plan.status == "solved"
    assert plan.iterations == 0  # no tree grew
    assert plan.trajectory is not None
    way = 2 * math.hypot(1.0, 1.5)  # [m], by a point
    assert way / PACE < plan.trajectory.duration < 3 * way / PACE


def test_a_mirrored_car_is_one_and_keeps_its_curves() -> None:
    """Its poses in the plane of (y, x) are those of the other one."""
    x, y, psi = (GOAL[key] for key in ("x", "y", "psi"))
    plan = load(car(PACE, mirrored=True)).solve(seed=1, improve=0)
    least = oracle.reeds_shepp_length((0.0, 0.0, 0.0), (y, x, psi), RADIUS)
    assert plan.cost == pytest.approx(least / PACE, rel=1e-6)


def test_a_car_that_is_slower_backward_weighs_its_gears() -> None:
    """Where it hardly goes backward, forward curves are the quicker ones."""
    found = curvature_car(load(car(PACE / 10)))
    assert found is not None
    assert found.radius == pytest.approx(RADIUS)
    assert found.speeds == pytest.approx({1: PACE, -1: PACE / 10})
    plan = load(car(PACE / 10)).solve(seed=1, improve=0)
    end = (GOAL["x"], GOAL["y"], GOAL["psi"])
    assert plan.cost is not None
    assert plan.cost <= oracle.dubins_length((0.0, 0.0, 0.0), end, RADIUS) / PACE * (1 + 1e-6)


def test_what_turns_on_the_spot_or_slips_is_no_such_car() -> None:
    x, y, psi = length("x"), length("y"), angle("psi")
    V = velocity(frame := move(x, y) @ rot_z(psi))
    body, ahead = Body("hull", frame, shape=Box(0.4, 0.2, 0.2)), Rate("v", on=V.x, limit=1.0)
    turn = Rate("w", on=psi, limit=1.0)
    unicycle = System("u", bodies=[body], constraints=[zero(V.y, "no slip")], inputs=[ahead, turn])
    crab = System("c", bodies=[body], inputs=[ahead, turn, Rate("aside", on=V.y, limit=1.0)])
    assert curvature_car(load(unicycle)) is None
    assert curvature_car(load(crab)) is None


def test_a_goal_that_is_no_pose_has_no_such_curve() -> None:
    assert curvature_car(load(car(PACE), goal={"x": 2.0, "y": 1.0, "tolerance": 0.1})) is None


@pytest.mark.parametrize("space", ["dubins", "reedsshepp"])
def test_planners_of_omplapp_join_poses_by_curves(space: str, tmp_path: Path) -> None:
    text = PLANE.replace("name = gap", f"statespace = {space}")
    problem = kinolab.load(problem_file(tmp_path, text))
    assert problem.scenario.planner.name == "auto"
    assert curvature_car(problem) is not None
    assert any("--planner kpiece drives at random" in note for note in problem.notes)


@pytest.mark.parametrize("seed", range(20))
def test_the_way_that_costs_least_by_its_length_is_reeds_and_shepp_s(seed: int) -> None:
    x, y, psi = np.random.default_rng(100 + seed).uniform(-3, 3, 3).tolist()
    problem = load(
        car(PACE),
        goal={"x": x, "y": y, "psi": psi, "tolerance": 0.01},
        objective={"length": {"hull": 1.0}},
    )
    plan = problem.solve(seed=1, improve=0)
    assert plan.status == "solved"
    least = oracle.reeds_shepp_length((0.0, 0.0, 0.0), (x, y, psi), RADIUS)
    assert plan.cost == pytest.approx(least, rel=0.01)
