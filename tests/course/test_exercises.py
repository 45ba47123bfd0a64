"""What an answer to an exercise is worth. The solutions run where the site is built."""

from __future__ import annotations

import re
from dataclasses import asdict
from math import cos
from pathlib import Path
from typing import Any

import pytest

from kinolab.dynamics import Body, System, angle, length, move, parameter, rot_y, toward
from kinolab.errors import InputError
from kinolab.testing import check
from kinolab.testing.answers.answers_from_afar import judging
from kinolab.testing.exercises import Mark, exercises, judged
from tests.support import ROOT

CHAPTERS = sorted((ROOT / "docs" / "course").glob("[0-9]*.md"))
NONSENSE = [..., None, "?", -7.3e6, lambda *_: None, lambda *_: "?", [], {}, object()]


def energies(q1: float, q2: float, r1: float, r2: float) -> tuple[float, float]:
    return r1**2 + 0.5 * r2**2 + r1 * r2 * cos(q1 - q2), -9.81 * (2 * cos(q1) + cos(q2))


@pytest.mark.parametrize("name", exercises())
def test_nonsense_is_refused_with_a_reason(name: str) -> None:
    for answer in NONSENSE:
        mark = check(name, answer)
        assert not mark, (name, answer)
        assert mark.points == 0
        assert mark.of == exercises()[name].points
        assert repr(mark).startswith(f"{name}: not yet: ")


def test_a_right_answer_has_all_points() -> None:
    mark = check("3.1", energies)
    assert mark
    assert mark.points == 2
    assert repr(mark) == "3.1: right, 2 points"


def test_another_zero_of_the_potential_energy_is_right_too() -> None:
    def higher(*case: float) -> tuple[float, float]:
        kinetic, potential = energies(*case)
        return kinetic, potential + 12.0

    assert check("3.1", higher)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda q1, q2, r1, r2: (r1**2 + 0.5 * r2**2, energies(q1, q2, r1, r2)[1]),
        lambda q1, q2, r1, r2: (energies(q1, q2, r1, r2)[0], -9.81 * (cos(q1) + cos(q2))),
        lambda q1, q2, r1, r2: (energies(q1, q2, r1, r2)[0], -energies(q1, q2, r1, r2)[1]),
    ],
)
def test_an_energy_that_lacks_a_term_is_not_right(wrong: Any) -> None:
    assert not check("3.1", wrong)


def test_a_stiff_rod_is_no_spring() -> None:
    r, theta = length("r", 0.2, 3.0, speed=5.0), angle("theta")
    ball = Body("ball", rot_y(theta) @ move(0, 0, -r), mass=parameter("m", 1.0, "kg"))
    free = System("free", bodies=[ball], gravity=toward("-z"))
    assert "the acceleration of r" in check("3.2", free).reason
    rod = Body("ball", rot_y(theta) @ move(0, 0, -1), mass=1.0)
    assert "r, r_dot is missing" in check("3.2", System("rod", bodies=[rod])).reason


def test_an_unknown_exercise_names_those_that_there_are() -> None:
    with pytest.raises(InputError, match=r"no exercise '3\.9'.*3\.1"):
        check("3.9", 1.0)


def test_a_grader_judges_and_keeps_the_marks(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Mark] = []

    def judge(name: str, answer: Any) -> dict[str, Any]:
        kept.append(judged(exercises()[name], answer))
        return asdict(kept[-1])

    with judging(judge) as address:
        monkeypatch.setenv("KINOLAB_GRADES", address)
        told = [check("3.3", 2.0), check("3.3", 1.5), check("3.1", energies), check("3.1", ...)]
        for name in exercises():
            for answer in NONSENSE:
                assert not check(name, answer), (name, answer)
    assert [mark.points for mark in kept[:4]] == [1, 0, 2, 0]
    assert told == kept[:4]


def test_where_solutions_are_shown_they_must_be_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KINOLAB_SOLUTIONS", "1")
    assert check("3.3", 2.0)
    with pytest.raises(AssertionError, match=r"3\.3: not yet"):
        check("3.3", 1.5)


@pytest.mark.parametrize("chapter", CHAPTERS, ids=lambda path: path.stem)
def test_each_exercise_has_a_stub_and_a_solution(chapter: Path) -> None:
    text = chapter.read_text(encoding="utf-8")
    cells = re.findall(r"```\{code-cell\} python\n(.*?)```", text, flags=re.DOTALL)
    number = str(int(chapter.stem[:2]))
    names = [name for name in exercises() if name.split(".")[0] == number]
    assert names, "a chapter has exercises"
    for name in names:
        its = [cell for cell in cells if f'check("{name}"' in cell]
        assert [re.findall(r":tags: \[(\w+)", cell) for cell in its] == [["exercise"], ["solution"]]
        assert "..." in its[0]
        assert f"**{name} (" in text
