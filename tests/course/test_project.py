"""Projects: a machine that is wrong obeys the laws of mechanics, and is worth half at most."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from kinolab.testing import grade, project
from kinolab.testing.exercises import Mark

BALL_AND_BEAM = """
from kinolab.dynamics import (
    WORLD, Body, Box, Sphere, System, Torque, angle, length, move, parameter, rate, rot_y, toward,
    zero,
)


def ball_beam():
    M, m = parameter("M", 1.0, "kg"), parameter("m", 0.2, "kg")
    L, R, d = parameter("L", 1.2, "m"), parameter("R", 0.04, "m"), parameter("d", 0.02, "m")
    alpha = angle("alpha", -0.5, 0.5, speed=4.0)
    r = length("r", -0.55, 0.55, speed=2.0)
    phi = angle("phi", speed=60.0)
    pivot = move(0, 0, 0.5) @ rot_y(alpha)
    uniform = (0.0006, M * L**2 / 12, M * L**2 / 12)
    beam = Body("beam", pivot, mass=M, inertia=uniform, shape=Box(L, 0.08, d))
    place = pivot @ move(r, 0, R + d / 2) @ rot_y(phi)
    ball = Body("ball", place, mass=m, inertia=2 * m * R**2 / 5, shape=Sphere(R))
    return System(
        "ball_beam",
        bodies=[beam, ball],
        constraints=[zero(rate(r) - R * rate(phi), "rolling")],
        inputs=[Torque("motor", on=beam, about=WORLD.y, limit=3.0)],
        gravity=toward("-z", 9.81),
    )
"""
TASK = """
schema = 1
title = "A ball rolls from one end of a driven beam to the other"
[system]
file = "NAME.py"
[start]
r = -0.45
[goal]
r = 0.45
alpha = 0.0
tolerance = 0.02
"""
WRONG = {  # what is written instead, and what the report says of it
    "gravity upward": ('"-z"', '"z"', "gravity is (0, 0, 9.81) m/s^2"),
    "gravity aside": ('"-z"', '"x"', "gravity is (9.81, 0, 0) m/s^2"),
    "no rolling": ('[zero(rate(r) - R * rate(phi), "rolling")]', "[]", "leave free is 3"),
    "rolling backward": ("rate(r) - R", "rate(r) + R", "phi changes by"),
    "frames swapped": (
        "pivot @ move(r, 0, R + d / 2) @", "move(r, 0, R + d / 2) @ pivot @", "ball is at",
    ),
    "degrees": ("rot_y(phi)", "rot_y(90)", "ball turns otherwise"),
    "grams": ('"m", 0.2', '"m", 200.0', "the mass of ball is 200 kg"),
    "kg cm^2": ("2 * m * R**2 / 5", "1.28", "inertia of ball is 1.28 kg m^2"),
    "kg mm^2": ("2 * m * R**2 / 5", "128.0", "inertia of ball is 128 kg m^2"),
    "half of the beam": ("L**2 / 12", "L**2 / 3", "inertia of beam is 0.48 kg m^2"),
    "moments in another order": (
        "(0.0006, M * L**2 / 12,", "(M * L**2 / 12, 0.0006,", "moments of inertia of beam about",
    ),
    "motor the other way": ("about=WORLD.y", "about=-WORLD.y", "the other way"),
    "another name": ('length("r"', 'length("s"', "no coordinate or rate is called 'r'"),
    "two motors": (
        "limit=3.0)]", 'limit=3.0), Torque("spin", on=ball, about=WORLD.y, limit=1.0)]',
        "its inputs are motor, spin",
    ),
}  # fmt: skip
ALONE = {  # what `plan examine` says of the machine by itself; a student's planted mistakes
    "as it is": "",
    "gravity upward": "gravity points up",
    "no rolling": "no rolling constraint: ball",
    "rolling backward": "rolling with the wrong sign: ball",
    "frames swapped": "touches at rest only: beam and ball",
    "degrees": "degrees: ball",
    "grams": "mass too large: ball",
    "kg cm^2": "inertia too large: ball",
    "kg mm^2": "inertia too large: ball",
}
OTHERWISE = {  # described in other words
    "velocity of the ball": ('gravity=', 'velocities=[alpha, r], gravity='),
    "gravity of the place": ("9.81", "9.8"),
    "phi of the world": (  # and not of the beam
        ' @ rot_y(phi)\n', ' @ rot_y(phi - alpha)\n',
    ),
    "input by place": ('Torque("motor"', 'Torque("tau"'),
    "names of bodies": ('Body("ball"', 'Body("marble"'),
}  # fmt: skip


def machine(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Write a machine that is changed, and its scenario."""
    code = BALL_AND_BEAM
    for old, new in changes:
        assert old in code
        code = code.replace(old, new)
    (folder / f"{name}.py").write_text(code)
    (folder / f"{name}.toml").write_text(TASK.replace("NAME", name))
    return folder / f"{name}.toml"


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plan is found for all of them, and has all points."""

    def marks(*_: Any) -> Iterator[Mark]:
        yield Mark("the plan", 6, 6)

    monkeypatch.setattr(project, "_planned", marks)
    monkeypatch.setattr(project, "load", lambda _: None)


@pytest.mark.usefixtures("planned")
@pytest.mark.parametrize(("old", "new", "told"), WRONG.values(), ids=WRONG)
def test_a_machine_that_moves_otherwise_has_half_of_the_points_at_most(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    asked = machine(tmp_path, "asked")
    report = grade(machine(tmp_path, "mine", (old, new)), against=asked)
    assert (report.points, report.of) == (6, 12)
    assert told in report.marks[0].reason


@pytest.mark.usefixtures("planned")
@pytest.mark.parametrize(("name", "told"), ALONE.items(), ids=ALONE)
def test_so_it_has_where_nothing_is_given_to_compare_it_with(
    name: str, told: str, tmp_path: Path
) -> None:
    report = grade(machine(tmp_path, "mine", *([WRONG[name][:2]] if told else [])))
    assert (report.points, report.of) == (6 if told else 12, 12)
    assert report.marks[0].reason.startswith(told), str(report)


@pytest.mark.usefixtures("planned")
@pytest.mark.parametrize("changes", [(), *OTHERWISE.values()], ids=["as it is", *OTHERWISE])
def test_a_machine_in_other_words_has_all_of_them(changes: Any, tmp_path: Path) -> None:
    asked = machine(tmp_path, "asked")
    given = machine(tmp_path, "mine", changes) if changes else asked
    if changes and "phi - alpha" in changes[1]:  # rolling is of phi less the beam's turn
        given = machine(
            tmp_path, "mine", changes, ("R * rate(phi)", "R * (rate(phi) - rate(alpha))")
        )
    report = grade(given, against=asked)
    assert (report.points, report.of) == (12, 12), str(report)


@pytest.mark.usefixtures("planned")
def test_what_is_due_is_said_where_it_may_be(tmp_path: Path) -> None:
    asked, wrong = machine(tmp_path, "asked"), machine(tmp_path, "mine", ('"-z"', '"z"'))
    due = "gravity is (0, 0, 9.81) m/s^2 where (0, 0, -9.81) is due"
    assert due not in str(grade(wrong, against=asked))
    assert due in str(grade(wrong, against=asked, due=True))
