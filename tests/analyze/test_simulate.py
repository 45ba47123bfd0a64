"""Machines that move by themselves: plan simulate, plan examine, plan new."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.analyze.examine import examine
from kinolab.analyze.simulate import simulate
from kinolab.cli import run
from kinolab.dynamics import Body, System, Torque, Wrench, angle, move, rate, rot_z
from kinolab.errors import InputError
from kinolab.loading import build_problem, find_scenario
from kinolab.scenario.starters.starter_files import STARTERS, write_starter
from tests.machines import MACHINES


def test_a_released_pendulum_falls_as_its_elliptic_integral_says() -> None:
    """From theta = 2 at rest; a quarter period is K(sin 1) sqrt(l/g) with K(sin 1) by the AGM."""
    a, b = 1.0, np.cos(1.0)
    for _ in range(6):
        a, b = (a + b) / 2, np.sqrt(a * b)
    quarter = np.pi / (2 * a) / np.sqrt(9.81)
    problem = build_problem(
        find_scenario("pendulum", overrides=["start.theta=2.0"]), planning=False
    )
    trajectory = simulate(problem, quarter)
    assert trajectory.duration == pytest.approx(quarter, abs=1e-12)
    assert trajectory.x[-1, 0] == pytest.approx(0.0, abs=1e-8)  # [rad], rtol of the integrator


def test_simulate_writes_a_run_that_can_be_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["simulate", "pendulum", "--start", "theta=1", "--duration", "0.5", "--quiet"]) == 0
    folder = tmp_path / "runs" / "pendulum_simulated"
    assert (folder / "animation.gif").is_file()
    with (folder / "trajectory.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["theta"]) == 1.0
    assert rows[0]["torque"] == "0.0"


def test_a_start_that_is_none_is_named_as_it_was_typed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", "pendulum", "--start", "thta=1", "--set", "start.omga=1"]) == 2
    told = capsys.readouterr().err
    assert "--start thta=1: no coordinate or rate is called 'thta'." in told
    assert "--set start.omga=1: no coordinate or rate is called 'omga'." in told


def test_inputs_from_a_file_are_held_until_the_next_row(tmp_path: Path) -> None:
    table = tmp_path / "inputs.csv"
    table.write_text("t,torque\n0,1.0\n0.2,-2.0\n")
    problem = build_problem(find_scenario("pendulum"), planning=False)
    trajectory = simulate(problem, 0.4, table)
    assert trajectory.u[:, 0].tolist() == [1.0] * 4 + [-2.0] * 4


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t\n0\n", "no column torque"),
        ("t,torque\n0,much\n", "no number"),
        ("t,torque\n0,1\n0,2\n", "does not increase"),
        ("", "no column t, torque"),
    ],
)
def test_a_file_of_inputs_with_a_mistake_is_refused(tmp_path: Path, text: str, told: str) -> None:
    table = tmp_path / "inputs.csv"
    table.write_text(text)
    problem = build_problem(find_scenario("pendulum"), planning=False)
    with pytest.raises(InputError, match=told):
        simulate(problem, 1.0, table)


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), float("inf"), 1e12])
def test_a_duration_that_is_none_is_refused(duration: float) -> None:
    problem = build_problem(find_scenario("pendulum"), planning=False)
    with pytest.raises(InputError, match="no duration"):
        simulate(problem, duration)


@pytest.mark.parametrize(
    "name", ["driven_crane", "wheeled_hull", "loose_snakeboard", "kinematic_car", "four_bar"]
)
def test_nothing_is_odd_about_sound_machines(name: str) -> None:
    assert examine(MACHINES[name]()).faults == ()


def test_a_kink_is_found() -> None:
    """A torque that jumps with the direction of motion has no derivative there."""
    theta = angle("theta", speed=1e-6)
    wheel = Body("wheel", rot_z(theta) @ move(0.1), mass=1.0)
    friction = Wrench(on=wheel, torque=(0, 0, -abs(rate(theta))))
    motor = Torque("motor", on=wheel, about=rot_z(theta).z, limit=1.0)
    found = examine(System("kinked", bodies=[wheel], efforts=[friction], inputs=[motor]))
    (law,) = [one.law for one in found.broken]
    assert law == "derivatives of the equations of motion equal finite differences"


def test_a_new_machine_runs_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["new", "my_puck"]) == 0
    assert run(["examine", "my_puck.py:my_puck"]) == 0
    assert run(["examine", "my_puck.py"]) == 0
    assert run(["equations", "my_puck.py", "--latex"]) == 0
    assert run(["my_puck.toml", "--quiet", "--no-animation"]) == 0
    assert run(["check", "runs/my_puck"]) == 0
    assert run(["simulate", "my_puck.py", "--quiet", "--no-animation"]) == 0


def test_a_new_machine_never_overwrites_and_needs_a_usable_name(tmp_path: Path) -> None:
    write_starter("puck", tmp_path)
    (tmp_path / "puck.toml").unlink()
    with pytest.raises(InputError, match=r"puck\.py: this file exists already"):
        write_starter("puck", tmp_path)
    assert not (tmp_path / "puck.toml").exists()
    with pytest.raises(InputError, match="cannot be the name"):
        write_starter("my-puck", tmp_path)


@pytest.mark.parametrize("kind", [kind for kind in STARTERS if kind != "puck"])
def test_other_machines_to_start_from_are_planned_for_as_they_are(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name = f"my_{kind.replace('-', '_')}"
    assert run(["new", name, f"--{kind}"]) == 0
    found = run([f"{name}.toml", "--no-animation", "--quiet", "--no-optimize"])
    assert found == 0  # solved and verified
    assert run(["examine", f"{name}.toml"]) == 0


@pytest.mark.parametrize("kind", STARTERS)
def test_machines_that_are_a_little_off_carry_out_the_plans_to_start_from(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_starter("mine", tmp_path, kind)
    assert run(["mine.toml", "--no-animation", "--quiet"]) == 0
    for seed in (1, 2, 3):
        options = ["--parameters", "0.05", "--seed", str(seed), "--no-picture", "--no-diagnosis"]
        assert run(["execute", "runs/mine", *options, "--quiet"]) == 0
        report = json.loads(Path("runs/mine/execution.json").read_text())
        assert report["reached"] >= 95


# --- from Python ---


def test_a_pendulum_under_a_policy_moves_as_its_closed_loop_says() -> None:
    """Torque m g l sin(theta) - k theta leaves m l^2 theta'' = -k theta, a harmonic oscillator."""
    m, l, g, k = 1.0, 1.0, 9.81, 4.0  # noqa: E741
    motion = kinolab.simulate(
        kinolab.systems.get("pendulum"),
        lambda _, x: m * g * l * np.sin(x[0]) - k * x[0],
        start={"theta": 0.3},
        duration=1.0,
        step=1e-3,
    )
    expected = 0.3 * np.cos(2.0 * motion.t)  # sqrt(k / m l^2) = 2 / s
    assert motion.x[:, 0] == pytest.approx(expected, abs=2e-3)  # the torque is held for 1 ms


def test_a_policy_of_time_is_the_file_of_the_same_inputs(tmp_path: Path) -> None:
    table = tmp_path / "inputs.csv"
    table.write_text("t,torque\n0,1.0\n0.2,-2.0\n")
    problem = build_problem(find_scenario("pendulum"), planning=False)
    told = kinolab.simulate(
        "pendulum", lambda t, _: {"torque": 1.0 if t < 0.199 else -2.0}, duration=0.4
    )
    read = simulate(problem, 0.4, table)
    assert told.u.tolist() == read.u.tolist()
    assert told.x == pytest.approx(read.x, abs=1e-8)  # the integrator starts anew at every step


def test_a_start_is_given_by_name_or_as_a_state() -> None:
    problem = kinolab.load("pendulum_swingup")
    x = kinolab.simulate(problem, start=[0.1, 0.0], duration=0.5)
    y = kinolab.simulate(problem, start={"theta": "0.1 rad"}, duration=0.5)
    assert x.x.tolist() == y.x.tolist()
    assert kinolab.simulate(problem, duration=0.1).x[0].tolist() == problem.start.tolist()


def test_what_a_policy_changes_in_its_arguments_changes_nothing() -> None:
    def careless(_: float, x: Any) -> float:
        x[:] = 0.0
        return 0.0

    free = kinolab.simulate("pendulum", start={"theta": 1.0}, duration=0.2)
    same = kinolab.simulate("pendulum", careless, start={"theta": 1.0}, duration=0.2)
    assert same.x == pytest.approx(free.x, abs=1e-8)


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        ({"machine": 3}, "simulate machine: it is 3. Give a System or"),
        ({"machine": "pendulm"}, "no system or scenario is called 'pendulm'. Did you mean"),
        ({"policy": 1.0}, "simulate policy: it is 1.0. Give a function of time and state, or None"),
        (
            {"policy": lambda *_: [1, 2]},
            "policy: it returned [1, 2] at t = 0 s. Return a finite number for each of torque",
        ),
        ({"policy": lambda *_: None}, "policy: it returned None at t = 0 s."),
        ({"policy": lambda *_: np.nan}, "policy: it returned nan at t = 0 s."),
        ({"policy": lambda *_: {"motor": 1}}, "policy: no input is called 'motor'."),
        ({"duration": -1.0}, "duration: -1 s is no duration for steps of 0.05 s."),
        ({"duration": "long"}, "simulate duration: it is 'long'. Give a number."),
        ({"start": [1.0]}, "simulate start: it has shape (1,), not (2,). The states are theta, "),
        ({"start": {"phi": 1}}, "simulate start: no coordinate or rate is called 'phi'."),
        ({"step": 0}, "simulate integration.step: 0 is too small."),
    ],
)
def test_an_argument_of_simulate_that_does_not_fit_is_named(
    arguments: dict[str, Any], answer: str
) -> None:
    with pytest.raises(InputError) as caught:
        kinolab.simulate(**{"machine": "pendulum", **arguments})
    assert str(caught.value).startswith(answer)
