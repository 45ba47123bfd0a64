"""Several machines in a scenario: planned as one, or one after the other; judged pair by pair."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.facts.machine_facts import members
from kinolab.errors import KinolabError
from kinolab.runs import check_run
from kinolab.scenario import write_scenario
from kinolab.simulation.reference import resimulate

RADIUS = 0.25


def coin(name: str, start: tuple[float, float], goal: tuple[float, float]) -> dict[str, Any]:
    return {
        "name": name,
        "system": {"name": "rolling_disk", "parameters": {"R": RADIUS}},
        "start": {"x": start[0], "y": start[1]},
        "goal": {"x": goal[0], "y": goal[1], "tolerance": 0.1},
        "metric": {"psi": 0.5, "phi": 0.001, "psi_dot": 0.1, "phi_dot": 0.1},
    }


def passing() -> dict[str, Any]:
    """Two coins that change places in a corridor."""
    return {
        "world": {"bounds": {"x": [0, 6], "y": [0, 2]}, "ground": "plane"},
        "machine": [coin("left", (1, 1), (5, 1)), coin("right", (5, 1), (1, 1))],
        "integration": {"step": 0.05},
    }


def disks_apart(problem: kinolab.Problem, plan: Any) -> float:
    """A bound on how far the coins are apart: segments across them, sampled, every millisecond."""
    t, u = plan.trajectory.t, plan.trajectory.inputs
    times = np.unique(np.concatenate([t, np.arange(0.0, t[-1], 1e-3)]))
    held = u[np.clip(np.searchsorted(t, times[:-1], "right") - 1, 0, len(u) - 1)]
    x = resimulate(problem, times, held).x
    names = problem.model.state_names
    along = np.linspace(-RADIUS, RADIUS, 41)

    def rims(machine: str) -> np.ndarray:
        px, py, psi = (x[:, names.index(f"{machine}_{c}")] for c in ("x", "y", "psi"))
        way = np.stack([np.cos(psi), np.sin(psi)], axis=1)
        return np.stack([px, py], axis=1)[:, None] + along[:, None] * way[:, None]

    a, b = rims("left")[::20], rims("right")[::20]
    return float(np.linalg.norm(a[:, :, None] - b[:, None], axis=3).min())


@pytest.mark.parametrize("planner", ["auto", "prioritized"])
def test_two_coins_pass_each_other(planner: str, tmp_path: Path) -> None:
    problem = kinolab.load(passing())
    plan = problem.solve(planner=planner, seed=1, improve=0)
    assert plan.status == "solved"
    assert disks_apart(problem, plan) > 0.0
    end = dict(zip(problem.model.state_names, plan.trajectory.x[-1], strict=True))
    for name, x in (("left", 5.0), ("right", 1.0)):
        assert abs(end[f"{name}_x"] - x) <= 0.1
        assert abs(end[f"{name}_y"] - 1.0) <= 0.1
    folder = Path(plan.save(tmp_path / "run"))
    assert check_run(folder).passed
    assert (folder / "assets" / "machine.json").exists()


def test_one_order_after_the_other() -> None:
    """Without a first attempt as one machine: the second avoids the first, which has its way."""
    from kinolab.planners.prioritized import Prioritized
    from kinolab.search import Budget, Outcome

    problem = kinolab.load(passing())
    alone = kinolab.load(
        {
            "system": {"name": "rolling_disk", "parameters": {"R": RADIUS}},
            "world": {"bounds": {"x": [0, 6], "y": [0, 2]}, "ground": "plane"},
            "start": {"x": 1, "y": 1},
            "goal": {"x": 5, "y": 1},
        }
    )
    assert alone.model.nx * 2 == problem.model.nx
    said: list[str] = []
    budget = Budget(60.0, told=said.append)
    found = Prioritized(iterations=1, attempts=20).solve(problem, 1, budget)
    assert found.outcome is Outcome.SOLVED
    left, right = members(problem.machine.name)
    among = "deriving and compiling {} among the motions of {}"
    assert {among.format(left, right), among.format(right, left)}.intersection(said)


def test_a_scenario_of_machines_says_what_each_begins_and_ends_with() -> None:
    problem = kinolab.load(passing())
    state = dict(zip(problem.model.state_names, problem.start, strict=True))
    assert (state["left_x"], state["right_x"]) == (1.0, 5.0)
    limits = dict(zip(problem.model.state_names, problem.bounds.tolist(), strict=True))
    assert limits["left_x"] == limits["right_x"] == [0.0, 6.0]
    weights = dict(zip(problem.model.state_names, problem.weights, strict=True))
    assert weights["right_psi"] == 0.5
    assert problem.scenario.planner.name == "prioritized"
    again = tomllib.loads(write_scenario(problem.scenario))
    assert again["system"]["machines"]["left"]["name"] == "rolling_disk"
    kinolab.load(again)


def test_one_of_them_comes_to_rest() -> None:
    table = passing()
    table["machine"][0]["goal"]["at_rest"] = True
    problem = kinolab.load(table)
    names = [problem.model.state_names[i] for i in problem.goal.indices]
    assert {"left_psi_dot", "left_phi_dot"} <= {*names}
    assert "right_psi_dot" not in names
    assert problem.goal.tolerances.tolist() == [0.1] * len(names)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t["machine"].pop(), "it is the only one"),
        (lambda t: t["machine"][1].update(name="left"), 'machine 1 is called "left", too'),
        (lambda t: t["machine"][1].update(name="my coin"), '"my coin" has other characters'),
        (lambda t: t["machine"][1].pop("name"), r"\[\[machine\]\] 2 name: the key is missing"),
        (lambda t: t["machine"][1].pop("system"), r"2 system: the section is missing"),
        (lambda t: t["machine"][1].update(system={}), "2 system: none of name and file is given"),
        (lambda t: t.update(start={"x": 1.0}), "stands beside"),
        (lambda t: t["machine"][1].update(colour="red"), "'colour'"),
        (lambda t: t["machine"][1]["start"].update(q=1.0), r"\[\[machine\]\] 2 start.q: .*right_q"),
        (
            lambda t: t["machine"][1]["start"].update(x=1.0, y=1.0),
            r"\[\[machine\]\] start: left_coin touches right_coin\. Move \[\[machine\]\] left or",
        ),
    ],
)
def test_machines_that_are_wrong(change: Any, sentence: str) -> None:
    table = passing()
    change(table)
    with pytest.raises(KinolabError, match=sentence):
        kinolab.load(table).check_endpoints()


@pytest.mark.parametrize("value", [3, "rolling_disk", [3, 3], True])
@pytest.mark.parametrize("key", ["name", "system", "start", "goal", "bounds", "metric"])
def test_no_key_of_a_machine_is_ignored_where_its_type_is_wrong(key: str, value: Any) -> None:
    table = passing()
    table["machine"][1][key] = value
    if (key, value) == ("name", "rolling_disk"):
        kinolab.load(table)
        return
    with pytest.raises(KinolabError) as caught:
        kinolab.load(table)
    assert f"[[machine]] 2 {key}: " in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1  # nothing that follows from it alone


@pytest.mark.parametrize("table", [3, {}, [], [{}, 3], [[], []]])
def test_what_is_no_list_of_machines_is_refused_in_words(table: Any) -> None:
    with pytest.raises(KinolabError, match=r"machine"):
        kinolab.load({**passing(), "machine": table})
