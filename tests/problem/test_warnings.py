"""What is said before a search about what may be meant otherwise."""

from __future__ import annotations

import pytest
from sympy import sqrt

import kinolab
from kinolab import dynamics as kd
from kinolab.problem.warnings import problem_warnings


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            "goal.psi=90",
            ('[goal] psi = 90 is in rad, more than a whole turn; "90 deg" is in degrees.',),
        ),
        (
            "start.psi=-45",
            ('[start] psi = -45 is in rad, more than a whole turn; "-45 deg" is in degrees.',),
        ),
        ('goal.psi="90 deg"', ()),
        ("goal.psi=3", ()),
        ('goal.psi="450 deg"', ()),  # whoever writes this knows
        ("goal.x=9", ()),
    ],
)
def test_angles_that_look_like_degrees(given: str, told: tuple[str, ...]) -> None:
    problem = kinolab.load("rolling_disk_maze", overrides=[given])
    assert problem_warnings(problem) == told


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (("goal.tolerance={ x = 0.1, psi_dot = 0.1 }",), ["psi_dot"]),
        (("goal.tolerance={ psi = 0.1, phi = 0.2 }",), ["psi", "phi"]),
        (("goal.tolerance={ x = 0.1, psi_dot = 0.1 }", "goal.at_rest=true"), []),
        (("goal.tolerance={ x = 0.1 }",), []),
        (('goal.tolerance={ "x*" = 0.1, "psi*" = 0.1 }',), ["psi*"]),  # of all that begins so
    ],
)
def test_a_tolerance_of_what_the_goal_leaves_free(given: tuple[str, ...], told: list[str]) -> None:
    problem = kinolab.load("rolling_disk_maze", overrides=["goal.at_rest=false", *given])
    wanted = [
        f"[goal] tolerance.{name} counts for nothing, since the goal leaves {name} free; "
        f"write {name} = value below [goal]."
        for name in told
    ]
    assert list(problem_warnings(problem)) == wanted


def test_a_tolerance_of_one_machine_is_of_what_its_goal_says() -> None:
    """Of two machines; the goal of the second leaves all but its height free."""
    problem = kinolab.load({
        "world": {"bounds": {"x": [0, 4], "y": [0, 4]}},
        "machine": [
            {"name": "a", "system": {"name": "diff_drive"}, "start": {"x": 1.0, "y": 1.0},
             "goal": {"x": 3.0, "y": 1.0, "tolerance": 0.2}},
            {"name": "b", "system": {"name": "rolling_disk"}, "start": {"x": 1.0, "y": 3.0},
             "goal": {"x": 3.0, "tolerance": {"x": 0.2, "psi": 0.1}}},
        ],
    })  # fmt: skip
    told = [one for one in problem_warnings(problem) if "counts for nothing" in one]
    assert [one.split()[1] for one in told] == ["tolerance.b_psi"]


@pytest.mark.parametrize(
    ("goal", "told"), [('at_rest=true,order="any"', True), ("at_rest=true", False),
                       ('order="any"', False)]
)  # fmt: skip
def test_a_rest_that_is_asked_of_one_of_the_goals_that_may_be_last(goal: str, told: bool) -> None:
    given = ["via=[{x=1.0,y=1.0},{x=2.0,y=1.0,at_rest=true}]", f"goal={{x=3.0,y=1.0,{goal}}}"]
    problem = kinolab.load("rolling_disk_maze", overrides=given)
    sentence = "In any order the motion may end in [[via]] 1, and need not be at rest there"
    assert any(one.startswith(sentence) for one in problem_warnings(problem)) is told


@pytest.mark.parametrize(("epsilon", "told"), [(0.0, True), (1e-3, False)])
def test_equations_without_derivatives_at_the_start_are_told(epsilon: float, told: bool) -> None:
    """Drag that grows with the square of two velocities, from rest."""
    x, z = kd.length("x", speed=5.0), kd.length("z", speed=5.0)
    ball = kd.Body("ball", kd.move(x, 0, z), mass=1.0, shape=kd.Sphere(0.1))
    u, v = kd.rate(x), kd.rate(z)
    speed = sqrt(u**2 + v**2 + epsilon**2)
    pushes = [kd.Force(f"f{n}", on=ball, along=a, limit=2.0) for n, a in
              (("x", kd.WORLD.x), ("z", kd.WORLD.z))]  # fmt: skip
    drag = [kd.Load(-0.3 * speed * u, u), kd.Load(-0.3 * speed * v, v)]
    system = kd.System("ball", bodies=[ball], inputs=pushes, efforts=drag)
    problem = kinolab.load({
        "system": system, "world": {"bounds": {"x": [0, 4], "z": [0, 4]}},
        "start": {"x": 0.5, "z": 0.5}, "goal": {"x": 3.0, "z": 3.0, "tolerance": 0.2},
    })  # fmt: skip
    assert any("has no derivative at the start" in one for one in problem_warnings(problem)) is told
    assert problem.solve(seed=1, improve=0.2).status == "solved"
