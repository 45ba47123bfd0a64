"""Obstacles that move in a scenario: plans that wait for them, and what is wrong with motions."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem.warnings import problem_warnings
from kinolab.runs import check_run
from kinolab.simulation.reference import resimulate

GATE = [[0, 3, 1, 0.5], [4, 3, 1, 0.5], [5, 3, 2.2, 0.5], [7, 3, 2.2, 0.5], [8, 3, 1, 0.5]]
RADIUS = 0.2


def corridor(**motion: Any) -> kinolab.Problem:
    """A coin in a corridor of 2 m with a wall, in whose gap something moves."""
    gate = {"name": "gate", "box": [0.2, 1.2, 1.0], "motion": motion}
    walls = [
        {"name": f"wall {k}", "box": [0.3, 0.6, 1.0], "position": [3.0, y, 0.5]}
        for k, y in enumerate((0.2, 1.8))
    ]
    return kinolab.load(
        {
            "system": {"name": "rolling_disk", "parameters": {"R": RADIUS}},
            "world": {
                "bounds": {"x": [0, 6], "y": [0, 2]},
                "ground": "plane",
                "obstacle": [*walls, gate],
            },
            "metric": {"psi": 0.5, "phi": 0.001, "psi_dot": 0.1, "phi_dot": 0.1},
            "start": {"x": 1, "y": 1},
            "goal": {"x": 5, "y": 1},
            "integration": {"step": 0.05},
        }
    )


def gate_at(times: np.ndarray, rows: list[list[float]]) -> np.ndarray:
    table = np.array(rows)
    return np.interp(times % table[-1, 0], table[:, 0], table[:, 2])


def least_gap(x: np.ndarray, times: np.ndarray, rows: list[list[float]]) -> float:
    """From the gate to the ball around the coin's centre, at samples."""
    centre = np.column_stack([x[:, 0], x[:, 1], np.full(len(x), RADIUS)])
    gate = np.column_stack([np.full(len(x), 3.0), gate_at(times, rows), np.full(len(x), 0.5)])
    half = np.array([0.1, 0.6, 0.5])
    nearest = np.clip(centre, gate - half, gate + half)
    return float(np.linalg.norm(centre - nearest, axis=1).min())


def densely(problem: kinolab.Problem, plan: Any) -> tuple[np.ndarray, np.ndarray]:
    t, u = plan.trajectory.t, plan.trajectory.inputs
    times = np.unique(np.concatenate([t, np.arange(0.0, t[-1], 1e-3)]))
    held = u[np.clip(np.searchsorted(t, times[:-1], "right") - 1, 0, len(u) - 1)]
    return times, resimulate(problem, times, held).x


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_coin_waits_for_a_gate(seed: int) -> None:
    problem = corridor(points=GATE, repeat=True)
    plan = problem.solve(seed=seed, improve=0)
    assert plan.status == "solved"
    assert plan.trajectory.duration > 4.5  # before, the gate leaves no way
    times, x = densely(problem, plan)
    np.testing.assert_allclose(x[:, problem.model.clocks[0]], times, atol=1e-9)
    thin = least_gap(x, times, GATE)
    assert thin > 0.0  # the coin's centre is never in the gate
    checker = problem.checker()
    assert checker.first_collision(problem.model.frames(x)) is None


def test_a_plan_among_things_that_move_is_checked_from_its_folder(tmp_path: Path) -> None:
    problem = corridor(points=GATE, repeat=True)
    plan = problem.solve(seed=1, improve=0)
    folder = Path(plan.save(tmp_path / "run"))
    assert check_run(folder).passed
    text = (folder / "scenario.toml").read_text()
    late = text.replace("[4.0, 3.0, 1.0, 0.5]", "[40.0, 3.0, 1.0, 0.5]").replace(
        "[5.0, 3.0, 2.2", "[41.0, 3.0, 2.2"
    )
    late = late.replace("[7.0, 3.0, 2.2", "[43.0, 3.0, 2.2").replace("[8.0, 3.0", "[44.0, 3.0")
    assert late != text
    (folder / "scenario.toml").write_text(late)
    assert not check_run(folder).passed


def test_motions_say_where_an_obstacle_is() -> None:
    """Each way of saying the same straight line."""
    at = (1.0, 2.0, 3.0)
    ways: list[dict[str, Any]] = [
        {"velocity": [0.5, 0.0, 0.0]},
        {"position": ["1 + t / 2", "2", "3"]},
        {"points": [[0, 1, 2, 3], [8, 5, 2, 3]]},
    ]
    for motion in ways:
        problem = kinolab.load("pendulum_swingup").with_obstacle(
            "cart", sphere=0.1, position=at if "velocity" in motion else (0, 0, 0), motion=motion
        )
        x = problem.start.copy()
        x[problem.model.clocks] = 4.0
        np.testing.assert_allclose(problem.frames(x).reshape(-1, 3, 4)[-1, :, 3], (3.0, 2.0, 3.0))


def test_a_door_that_turns_goes_on_turning() -> None:
    """Rows of a whole turn in 8 s, again and again; plans may take as long as they last."""
    rows = [[2 * k, 1, 2, 0.5, 0, 0, k * np.pi / 2] for k in range(5)]
    problem = kinolab.load("pendulum_swingup").with_obstacle(
        "door", box=(1.0, 0.1, 1.0), motion={"points": rows, "repeat": True}
    )
    (clock,) = problem.model.clocks
    assert problem.bounds[clock].tolist() == [0.0, 600.0]
    for t in (1.0, 7.9, 8.1, 100.3, 555.5):
        x = problem.start.copy()
        x[clock] = t
        along = problem.frames(x).reshape(-1, 3, 4)[-1, :2, 0]
        np.testing.assert_allclose(along, (np.cos(np.pi / 4 * t), np.sin(np.pi / 4 * t)), atol=1e-7)


def test_a_table_of_poses(tmp_path: Path) -> None:
    times = np.linspace(0.0, 6.0, 601)
    rows = [f"{t},{np.cos(t)},{np.sin(t)},0.5,0,0,{t}" for t in times]
    (tmp_path / "cart.csv").write_text("t,x,y,z,roll,pitch,yaw\n" + "\n".join(rows))
    scenario = tmp_path / "table.toml"
    scenario.write_text(
        'schema = 1\ntitle = "table"\n[system]\nname = "pendulum"\n[start]\n[goal]\ntheta = 3.14\n'
        "[[world.obstacle]]\nname = 'cart'\nbox = [0.1, 0.1, 0.1]\n"
        'motion = { file = "cart.csv" }\n'
    )
    problem = kinolab.load(scenario)
    assert problem.world.clearance == pytest.approx(1e-3)  # how far it may be beside its path
    for t in (0.0, 1.234, 5.9):
        x = problem.start.copy()
        x[problem.model.clocks] = t
        at = problem.frames(x).reshape(-1, 3, 4)[-1]
        np.testing.assert_allclose(at[:, 3], (np.cos(t), np.sin(t), 0.5), atol=1e-3)
        np.testing.assert_allclose(at[:2, 0], (np.cos(t), np.sin(t)), atol=3e-3)


def test_ends_of_a_long_beam_in_a_table_are_where_it_says(tmp_path: Path) -> None:
    """A turn moves them by metres: they stay within the millimetre that plans keep."""
    times = np.linspace(0.0, 4.0, 401)
    yaw = 0.5 * np.sin(times)
    rows = [f"{t},0,0,9,0,0,{a}" for t, a in zip(times, yaw, strict=True)]
    (tmp_path / "beam.csv").write_text("t,x,y,z,roll,pitch,yaw\n" + "\n".join(rows))
    scenario = tmp_path / "beam.toml"
    scenario.write_text(
        'schema = 1\ntitle = "beam"\n[system]\nname = "pendulum"\n[goal]\ntheta = 3.14\n'
        "[[world.obstacle]]\nbox = [12, 0.1, 0.1]\nmotion = { file = 'beam.csv' }\n"
    )
    problem = kinolab.load(scenario)
    x = np.tile(problem.start, (len(times), 1))
    x[:, problem.model.clocks] = times[:, None]
    beam = problem.frames(x).reshape(len(times), -1, 3, 4)[:, -1]
    ends = beam[:, :, :3] @ (6.0, 0.0, 0.0) + beam[:, :, 3]
    true = np.column_stack([6.0 * np.cos(yaw), 6.0 * np.sin(yaw), np.full(len(times), 9.0)])
    assert np.linalg.norm(ends - true, axis=1).max() <= problem.world.clearance


def test_the_machine_of_a_run_has_its_motion() -> None:
    with pytest.raises(InputError, match="the machine of another plan moves as was planned there"):
        kinolab.load("pendulum_swingup").replace(
            **{"world.obstacle": [{"run": "runs/x", "motion": {"velocity": [1, 0, 0]}}]}
        )


def test_what_goes_on_and_hits_a_machine_that_waits_is_said() -> None:
    problem = kinolab.load(
        {
            "system": "diff_drive",
            "world": {
                "bounds": {"x": [0, 8], "y": [0, 4]},
                "ground": "plane",
                "obstacle": [
                    {
                        "name": "cart",
                        "box": [0.6, 0.6, 0.6],
                        "position": [4, -6, 0.3],
                        "motion": {"velocity": [0, 0.5, 0]},
                    }
                ],
            },
            "start": {"x": 1, "y": 2},
            "goal": {"x": 4, "y": 2, "at_rest": True},
            "integration": {"step": 0.1},
        }
    )
    plan = problem.solve(seed=1, improve=0.5)
    assert plan.status == "solved"
    (sentence,) = [w for w in plan.warnings if "after the plan's end" in w]
    assert sentence.startswith("cart meets ")
    seconds = float(sentence.split(" s after")[0].rsplit(" ", 1)[1])
    # Its front is at the robot, about 0.3 m before the goal, once it has gone 7.4 m.
    assert plan.trajectory.duration + seconds == pytest.approx(14.8, abs=0.8)


@pytest.mark.parametrize(
    ("motion", "sentence"),
    [
        ({}, "nothing says how it moves"),
        ({"velocity": [1, 0, 0], "points": GATE}, "are given together"),
        ({"velocity": [1, 0, 0], "repeat": True}, "repeat is a key of points and files only"),
        ({"points": [[1, 0, 0, 0], [0, 1, 0, 0]]}, "its times do not rise"),
        ({"points": [[0, 0, 0, 0], [1, 1, 0, 0]], "repeat": True}, "not end where it begins"),
        ({"points": [[0, 0, 0], [1, 1, 0]]}, "neither four nor seven numbers"),
        ({"position": ["t", "q", "0"]}, "no name is called 'q'"),
        ({"file": "nowhere.csv"}, "nowhere.csv"),
        ({"file": "../out.csv"}, "does not lead to a file below the scenario's folder"),
    ],
)
def test_motions_that_are_wrong(motion: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        corridor(**motion)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("t,x,y,z\n0,0,0,0\n1,1,,0\n", "line 3, column y: it is empty"),
        ("t,x,y,z\n0,0,0,0\n\n1,1,0,abc\n", "line 4, column z: 'abc' is no finite number"),
        ("t,x,y,z\n0,0,nan,0\n1,1,0,0\n", "line 2, column y: 'nan' is no finite number"),
        ("t,x,y,z\n0,0,0\n1,1,0,0\n", "line 2 has 3 entries, not 4"),
    ],
)
def test_a_table_of_poses_that_is_wrong_says_where(
    table: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.csv").write_text(table)
    with pytest.raises(InputError, match=sentence):
        corridor(file="cart.csv")


@pytest.mark.parametrize("names", ["t,x,y,z,yaw", "yaw,z,y,x,t", "t,x,y,z,roll,pitch,yaw"])
def test_columns_of_a_table_go_by_their_names(
    names: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    pose = {"x": 4.0, "y": 5.0, "z": 6.0, "yaw": 0.3}
    rows = [{"t": t, **pose, "x": 4.0 + t} for t in (0.0, 1.0)]
    lines = [",".join(str(row.get(name, 0.0)) for name in names.split(",")) for row in rows]
    (tmp_path / "cart.csv").write_text("\n".join([names, *lines]))
    problem = corridor(file="cart.csv")
    at = problem.frames(problem.start).reshape(-1, 3, 4)[-1]
    np.testing.assert_allclose(at[:, 3], (4.0, 5.0, 6.0), atol=1e-9)
    np.testing.assert_allclose(at[:2, 0], (np.cos(0.3), np.sin(0.3)), atol=1e-9)


@pytest.mark.parametrize(("period", "turn", "said"), [(1, 0.35, 0), (1000, 0.35, 1), (1, 20, 1)])
def test_times_in_milliseconds_and_angles_in_degrees_are_noticed(
    period: float, turn: float, said: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = [f"{period * k},9,{k * k},0.5,{turn * k}" for k in range(10)]
    (tmp_path / "cart.csv").write_text("\n".join(["t,x,y,z,yaw", *rows]))
    found = [
        s for s in problem_warnings(corridor(file="cart.csv")) if " ms " in s or "degrees" in s
    ]
    assert len(found) == said


@pytest.mark.parametrize(
    ("formula", "at"),
    [
        ("3 + 1 / (t - 2)", 2.0),
        ("1 / (t - 7.3)**2", 7.3),
        ("2 + log(t)", 0.0),
        ("sqrt(5 - t)", 5.0),
        ("sqrt(t - 5)", 0.0),
        ("tan(t)", np.pi / 2),
        ("1 / (1 + sin(t))", 3 * np.pi / 2),  # whose divisor has no change of sign
        ("exp(exp(t))", np.log(np.log(np.finfo(float).max))),
        ("1 / 0", 0.0),
        *((text, None) for text in ("sin(t) / (t + 1)", "1 / (2 + cos(t))", "abs(t - 3)")),
        *((text, None) for text in ("max(t - 2, 0)", "1 / (1 + exp(30 - t))", "log(t + 1)")),
    ],
)
def test_where_a_formula_is_not_finite_is_said(formula: str, at: float | None) -> None:
    motion = {"position": ["9", formula, "0.5"]}
    if at is None:
        corridor(**motion)
        return
    with pytest.raises(InputError, match=r"obstacle\]\] 3 motion.position: .* of gate") as caught:
        corridor(**motion)
    said = re.search(r"at t = (\S+) s\.", str(caught.value))
    assert said
    assert float(said[1]) == pytest.approx(at, abs=0.061)  # the last is known to a sample
    assert ("or [bounds] time = [0, " in str(caught.value)) == (at > 0.0)


@pytest.mark.parametrize(
    ("placed", "motion", "sentence"),
    [
        ("position", {"points": GATE}, "position is not used, because motion.points says"),
        ("position", {"file": "gate.csv"}, "position is not used, because motion.file says"),
        ("position", {"position": ["t", "0", "0"]}, "because motion.position says"),
        ("rpy", {"rpy": ["0", "0", "t"]}, "rpy is not used, because motion.rpy says"),
        ("rpy", {"points": [[0] * 7, [1] * 7]}, "its rows have angles, and rpy is not used"),
    ],
)
def test_a_pose_that_is_not_used_is_refused(
    placed: str, motion: dict[str, Any], sentence: str
) -> None:
    gate = {"box": [0.2, 1.2, 1.0], placed: [1, 2, 3], "motion": motion}
    table = {"system": {"name": "rolling_disk"}, "start": {}, "goal": {"x": 5, "y": 1}}
    with pytest.raises(InputError, match=sentence):
        kinolab.load({**table, "world": {"obstacle": [gate]}})


@pytest.mark.parametrize(("hollow", "said"), [(False, False), (True, True)])
def test_a_mesh_that_moves_as_its_hull_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hollow: bool, said: bool
) -> None:
    import trimesh

    monkeypatch.chdir(tmp_path)
    solid = trimesh.creation.annulus(0.3, 0.5, 0.2) if hollow else trimesh.creation.icosphere()
    solid.export(tmp_path / "ring.stl")
    problem = kinolab.load(
        {
            "system": {"name": "rolling_disk"},
            "world": {"obstacle": [{"mesh": "ring.stl", "motion": {"spin": [0, 0, 1]}}]},
            "start": {"x": -3},
            "goal": {"x": -5, "y": 1},
            "bounds": {"x": [-6, 6], "y": [-6, 6]},
        }
    )
    assert ("ring moves as its convex hull." in problem_warnings(problem)) == said


def test_planners_in_worlds_that_stand_still_are_refused() -> None:
    with pytest.raises(InputError, match="prm plans in a world that stands still"):
        corridor(points=GATE).solve(planner="prm")
