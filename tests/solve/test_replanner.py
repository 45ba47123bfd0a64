"""Planning again while a machine moves: what is answered holds, and so does the stop behind it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinolab.api import Problem
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.solve.replanning import replanner
from kinolab.solve.replanning.replanner import Replanner, later
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.support import OPEN, problem_of

BOX = """
[[world.obstacle]]
name = "crate"
box = [0.3, 0.3, 0.6]
position = [2.0, 3.0, 0.3]
"""
FAR = OPEN.replace("x = -1.0", "x = -3.0").replace("x = 0.0", "x = 3.0")
IN_TIME, LATE = 60.0, -1.0  # [s] deadlines where the clock stands still


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Replanner:
    """Return a planner that has all the time it needs."""
    monkeypatch.setattr(replanner, "time", SimpleNamespace(monotonic=lambda: 0.0))
    monkeypatch.setattr(replanner, "SEARCH", IN_TIME)  # searches go by a clock that does not stand
    problem = Problem.of(problem_of(tmp_path, FAR + BOX))
    return problem.replanner(
        problem.solve("rrt_fast", seed=1, improve=2.0), deadline=IN_TIME, tolerance=0.0
    )


def beside(asked: Replanner, seconds: float, seed: int = 0) -> Array:
    """Return a state near that of the motion so many seconds after the last question."""
    near = asked.last.trajectory.at(seconds).x.copy()
    near[:3] += 0.01 * np.random.default_rng(seed).normal(size=3)  # [m] and [rad]
    return near


def test_undisturbed_all_of_the_motion_is_kept(asked: Replanner) -> None:
    before = asked.last.trajectory
    answer = asked.replan(before.x[4], float(before.t[4]))
    assert (answer.by, answer.proofs) == ("kept", ())
    assert np.array_equal(answer.trajectory.x, before.x[4:])
    assert verify(answer.problem, answer.trajectory).passed


def test_measured_states_near_the_motion_keep_it(asked: Replanner) -> None:
    """What ``at`` interpolates and what a sensor says are off, for the machine's control to mend.

    So it is at the end, too, where the machine stands in its goal and goes on standing.
    """
    asked.tolerance, scales = 0.01, asked.problem.scales  # of each entry's scale
    noise = np.random.default_rng(0)
    left = asked.last.trajectory.duration
    while left > 0.0:
        seconds = min(0.07, left)
        measured = asked.last.trajectory.at(seconds).x
        measured += 0.005 * scales * noise.uniform(-1.0, 1.0, len(scales))
        answer = asked.replan(measured, seconds)
        assert answer.by == "kept"
        assert 0.0 < answer.off < 0.01
        assert verify(answer.problem, answer.trajectory).passed
        assert answer.trajectory.duration == pytest.approx(left - seconds)
        left = answer.trajectory.duration
    assert asked.replan(asked.last.trajectory.x[-1], 5.0).by == "kept"


def test_a_machine_that_is_elsewhere_is_told_by_how_much(asked: Replanner) -> None:
    """Nothing was proved from there, and the stop begins where the machine should be."""
    asked.deadline = LATE
    state = asked.last.trajectory.x[0].copy()
    state[1] += 1.0  # [m]
    answer = asked.replan(state, 0.0)
    assert answer.by == "stop"
    assert answer.off == pytest.approx(1.0 / asked.problem.scales[1])
    assert verify(answer.problem, answer.trajectory).passed


def test_a_way_that_was_searched_for_is_shortened_while_the_machine_follows_it(
    asked: Replanner, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From where the machine is not yet; what comes before is kept as it is."""
    slow = asked.problem.solve("rrt_fast", seed=1, improve=0)  # type: ignore[attr-defined]
    monkeypatch.setattr(replanner, "SEARCH", 0.3 * slow.duration / 2.0)
    answer = replace(asked.last, by="searched", trajectory=slow.trajectory)
    asked._asked = 1
    asked.follow(answer)
    assert asked._shorter is not None
    monkeypatch.setattr(replanner, "Budget", lambda _: SimpleNamespace(elapsed=0.0))
    asked._shorten()
    asked._idle.set()
    assert asked._shorter.wait()
    before = asked.last.trajectory
    asked._idle.clear()
    short = asked.replan(before.x[1], float(before.t[1]))
    assert short.by == "shortened"
    assert short.trajectory.duration < 0.95 * before.duration
    assert short.trajectory.x[1] == pytest.approx(before.x[2])
    assert verify(short.problem, short.trajectory).passed


def test_what_no_longer_fits_is_mended_again_and_again(asked: Replanner) -> None:
    """Each answer begins where the machine is, and holds as a whole, not in parts only."""
    for k in range(4):
        state = beside(asked, 0.1, k)
        answer = asked.replan(state, 0.1)
        assert answer.by == "mended"
        assert answer.trajectory.x[0] == pytest.approx(state)
        assert verify(answer.problem, answer.trajectory).passed
        assert answer.proofs[0].end < answer.trajectory.duration  # the rest is kept


def test_an_obstacle_that_jumps_onto_the_way_is_gone_round(asked: Replanner) -> None:
    onto = asked.last.trajectory.at(0.5 * asked.last.trajectory.duration).x
    place = (float(onto[0]), float(onto[1]) + 0.1, 0.3)
    answer = asked.replan(beside(asked, 0.1), 0.1, {"crate": place})
    assert answer.by in {"mended", "searched"}
    assert verify(answer.problem, answer.trajectory).passed
    (moved,) = answer.problem.world.obstacles
    assert moved.bounding_box()[0] == pytest.approx(np.array(place) - [0.15, 0.15, 0.3])
    # The scenario tells the same: the world that is built from it is this one.
    assert answer.problem.scenario.world.obstacle[0].position == place


def test_what_is_late_is_a_stop_that_had_been_proved(asked: Replanner) -> None:
    asked.replan(beside(asked, 0.1), 0.1)
    asked.deadline = LATE
    state = asked.last.trajectory.x[0]
    answer = asked.replan(state, 0.0)
    assert answer.by == "stop"
    assert verify(answer.problem, answer.trajectory).passed
    assert answer.problem.rests(answer.trajectory.x[-1])
    over = asked.replan(answer.trajectory.x[-1], answer.trajectory.duration + 1.0)
    assert (over.by, over.trajectory.duration) == ("stop", 0.0)


def test_what_jumped_while_it_stopped_is_gone_round_afterwards(asked: Replanner) -> None:
    """The way that is kept had been proved before the jump, of which only the stop was told."""
    onto = asked.last.trajectory.at(0.6 * asked.last.trajectory.duration).x
    place = (float(onto[0]), float(onto[1]) + 0.35, 0.3)
    asked.replan(beside(asked, 0.1), 0.1)
    asked.deadline = LATE
    stopped = asked.replan(asked.last.trajectory.x[0], 0.0, {"crate": place})
    asked.deadline = IN_TIME
    answer = asked.replan(stopped.trajectory.x[0], 0.0)
    assert answer.by != "stop"
    assert verify(answer.problem, answer.trajectory).passed


def test_after_a_stop_it_goes_on(asked: Replanner) -> None:
    asked.replan(beside(asked, 0.1), 0.1)
    asked.deadline = LATE
    stopped = asked.replan(asked.last.trajectory.x[0], 0.0)
    asked.deadline = IN_TIME
    answer = asked.replan(stopped.trajectory.x[-1], stopped.trajectory.duration)
    assert answer.by in {"mended", "searched"}
    assert verify(answer.problem, answer.trajectory).passed


def test_a_search_goes_on_while_the_machine_stops(
    asked: Replanner, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not begun anew with each question, and what it finds begins where the stop ends."""
    searched: list[Array] = []
    go_on = Event()
    searching = replanner.motion

    def counted(task: PlanningTask, *rest: Any) -> Trajectory | None:
        searched.append(task.start)
        go_on.wait()
        return searching(task, *rest)

    monkeypatch.setattr(replanner, "motion", counted)
    monkeypatch.setattr(Replanner, "_nearest", lambda _: None)  # nothing is left of the old way
    asked.replan(beside(asked, 0.1), 0.1)
    asked.deadline, standing = LATE, asked.stop.trajectory.x[-1]
    for _ in range(3):
        stopped = asked.replan(asked.last.trajectory.at(0.1).x, 0.1)
        assert stopped.by == "stop"
    go_on.set()
    asked.deadline = IN_TIME
    answer = asked.replan(asked.last.trajectory.at(0.1).x, 0.1)
    assert answer.by == "searched"
    assert searched == [pytest.approx(standing)]
    assert verify(answer.problem, answer.trajectory).passed
    assert answer.proofs[-1].end == pytest.approx(answer.trajectory.duration)


def test_the_machine_stops_sooner_before_what_jumps_into_its_stop(asked: Replanner) -> None:
    """So it does even if no other motion is found; nothing is promised within its stopping way."""
    asked.replan(beside(asked, 0.1), 0.1)
    state, stop = asked.stop.trajectory.at(0.1).x, asked.stop.trajectory
    away = np.linalg.norm(stop.x[:, :2] - stop.x[-1, :2], axis=1).max()
    onto = stop.x[-1, :2] + 0.55 * (stop.x[-1, :2] - state[:2]) / np.linalg.norm(
        stop.x[-1, :2] - state[:2]
    )
    assert away > 0.0
    place = (float(onto[0]), float(onto[1]), 0.3)
    answer = asked.replan(state, 0.1, {"crate": place})
    assert verify(answer.problem, answer.trajectory).passed
    there = replace(asked.stop.problem, world=answer.problem.world)
    assert verify(there, asked.stop.trajectory).passed


def test_a_motion_goes_on_between_its_knots(asked: Replanner) -> None:
    known = asked.last.trajectory
    rest = later(asked.problem, known, float(known.t[3]) + 0.01)
    assert rest is not None
    assert rest.t[0] == 0.0
    assert rest.t[-1] == pytest.approx(known.duration - known.t[3] - 0.01)
    assert rest.u == pytest.approx(known.u[3:])
    whole = replace(asked.problem, start=rest.x[0])
    assert verify(whole, rest).passed
    assert later(asked.problem, known, known.duration) is None


def test_an_unknown_obstacle_is_named(asked: Replanner) -> None:
    with pytest.raises(InputError, match=r"no obstacle is called 'crat'\. Did you mean 'crate'\?"):
        asked.replan(asked.last.trajectory.x[0], 0.0, {"crat": (0.0, 0.0, 0.0)})


def test_questions_that_are_none_are_refused(asked: Replanner) -> None:
    start = asked.problem.start
    wrong: list[tuple[tuple[Any, ...], str]] = [
        (([0.0, 0.0], 0.0), r"replan start: it has shape \(2,\)"),
        (({"x": 0.0}, 0.0), "replan start: it is dict, and not made of numbers"),
        ((start, -1.0), "replan elapsed: it is -1 s"),
        ((start, float("nan")), "replan elapsed: it is nan s"),
        ((start, "0.1"), "replan elapsed: it is '0.1'"),
        ((start, 0.0, {"crate": (2.0, 3.0)}), r"obstacles crate: it has shape \(2,\)"),
        ((start, 0.0, {"crate": (2.0, 3.0, float("nan"))}), "obstacles crate: it has a number"),
        ((start, 0.0, ["crate"]), "replan obstacles: it is"),
    ]
    for arguments, told in wrong:
        with pytest.raises(InputError, match=told):
            asked.replan(*arguments)


@pytest.mark.parametrize("name", ["deadline", "period", "tolerance"])
def test_settings_that_are_none_are_refused(tmp_path: Path, name: str) -> None:
    problem = Problem.of(problem_of(tmp_path, FAR + BOX))
    for value in (-1.0, float("nan")):
        with pytest.raises(InputError, match=f"replanner {name}: it is {value:g}"):
            problem.replanner(**{name: value})


def test_an_obstacle_that_moves_by_itself_is_not_moved(tmp_path: Path) -> None:
    """Others are; it keeps to its own motion."""
    own = BOX.replace("crate", "cart") + "motion = { velocity = [0.1, 0.0, 0.0] }\n"
    problem = Problem.of(problem_of(tmp_path, FAR + BOX.replace("3.0", "-3.0") + own))
    asked = problem.replanner(problem.solve("rrt_fast", seed=1, improve=0))
    with pytest.raises(InputError, match="the obstacle 'cart' moves by itself"):
        asked.replan(problem.start, 0.0, {"cart": (0.0, 0.0, 0.0)})


def test_there_is_nothing_to_begin_with_without_a_plan(tmp_path: Path) -> None:
    problem = Problem.of(problem_of(tmp_path, FAR + BOX))
    nothing = replace(problem.solve("rrt_fast", seed=1, max_iterations=1), status="not_found")
    with pytest.raises(InputError, match="replanner plan: there is no plan to begin with"):
        problem.replanner(nothing)
