"""``tube.json`` is proved again by ``plan check``; one that says more is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.dynamics import Body, Force, Sphere, System, Viscous, length, move, parameter, rate
from kinolab.runs import check_run, write_run
from kinolab.simulation.reference import resimulate
from kinolab.solve import PlanResult

Data = dict[str, Any]


def cart() -> System:
    m, c, x = (
        parameter("m", 2.0, "kg"),
        parameter("c", 0.5, "N s/m"),
        length("x", -5.0, 5.0, speed=2.0),
    )
    frame = move(x)
    body = Body("cart", frame, mass=m, shape=Sphere(0.1))
    return System(
        "cart",
        bodies=[body],
        inputs=[Force("push", on=body, along=frame.x, limit=4.0)],
        efforts=[Viscous(rate(x), c)],
    )


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run beside a post, whose tube was proved."""
    post = {"name": "post", "box": [0.1, 1.0, 1.0], "position": [1.5, 0.0, 0.0]}
    problem = kinolab.load(
        {
            "system": cart(),
            "world": {"obstacle": [post]},
            "goal": {"x": 0.4, "tolerance": 0.2},
            "integration": {"step": 0.05},
        }
    )
    push = np.where(np.arange(40) < 20, 1.0, -1.0)[:, None]
    motion = resimulate(problem, 0.05 * np.arange(41.0), push)
    folder = tmp_path_factory.mktemp("tube")
    write_run(
        folder, problem, PlanResult("solved", motion, None, "rrt", 1, 1, 0.0, {"search": 0.0})
    )
    assert run(["prove", str(folder), "--percent", "3", "--quiet"]) == 0
    return folder


def tube_check(folder: Path) -> Any:
    (found,) = (c for c in check_run(folder).checks if c.name == "tube")
    return found


def test_what_was_proved_is_proved_again(finished: Path) -> None:
    assert tube_check(finished).passed
    data = json.loads((finished / "tube.json").read_text())
    assert data["share"] == 1.0
    assert data["proof"]["uncertainty"]["parameters"] == {"m": 0.03, "c": 0.03}


def wider(data: Data) -> None:
    data["proof"]["uncertainty"]["parameters"]["m"] = 0.2
    data["asked"]["parameters"]["m"] = 0.2


def wider_in_words(data: Data) -> None:
    data["asked"]["parameters"]["m"] = 0.2


def noisier(data: Data) -> None:
    data["proof"]["uncertainty"]["noise"] = data["asked"]["noise"] = 1e-3


def another_gain(data: Data) -> None:
    data["proof"]["large"] = 0.19


def narrower(data: Data) -> None:
    data["proof"]["high"]["x"] = [0.999 * value for value in data["proof"]["high"]["x"]]


def nearer_the_goal(data: Data) -> None:
    data["proof"]["excess"] *= 0.999


def more_room(data: Data) -> None:
    data["proof"]["spare"] += 1e-3


def no_share(data: Data) -> None:
    data["share"] = 0.0


def not_a_table(data: Data) -> None:
    data["proof"] = []


@pytest.mark.parametrize(
    "change",
    [wider, wider_in_words, noisier, another_gain, narrower, nearer_the_goal, more_room, no_share,
     not_a_table],
)  # fmt: skip
def test_a_claim_that_was_changed_is_refused(
    finished: Path, change: Callable[[Data], None]
) -> None:
    file = finished / "tube.json"
    kept = file.read_text()
    try:
        data = json.loads(kept)
        change(data)
        file.write_text(json.dumps(data))
        assert not tube_check(finished).passed
    finally:
        file.write_text(kept)


def test_an_obstacle_that_is_a_millimetre_nearer_is_refused(finished: Path) -> None:
    """Even where the hashes of all files were written anew."""
    from kinolab.runs.assets import digest_of

    scenario, file = finished / "scenario.toml", finished / "tube.json"
    kept = scenario.read_text(), file.read_text()
    try:
        assert "1.5" in kept[0]
        scenario.write_text(kept[0].replace("1.5", "1.499"))
        assert not tube_check(finished).passed
        data = json.loads(kept[1])
        data["files"]["scenario.toml"] = digest_of(scenario.read_bytes())
        file.write_text(json.dumps(data))
        assert not tube_check(finished).passed
    finally:
        scenario.write_text(kept[0])
        file.write_text(kept[1])


def test_what_is_not_proved_says_when_and_up_to_where(
    finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = (finished / "tube.json").read_text()
    try:
        assert run(["prove", str(finished), "--percent", "90", "--quiet"]) == 7
        told = capsys.readouterr().out
        assert "not proved for c, m within 90 %" in told
        assert "proved up to" in told
        assert tube_check(finished).passed
    finally:
        (finished / "tube.json").write_text(kept)
