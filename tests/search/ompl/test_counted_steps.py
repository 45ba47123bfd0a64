"""How many steps OMPL's planners simulate: those that anybody who listens would count."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from kinolab import planners
from kinolab.search import Budget
from kinolab.search.ompl import state_propagator
from kinolab.simulation import Propagator, rollout
from tests.support import OPEN, problem_of


class Listener(Propagator):
    """A propagator that says when it makes a step."""

    heard = 0

    def step(self, *arguments: Any) -> Any:
        """Count, and make the step."""
        Listener.heard += 1
        return super().step(*arguments)


@pytest.mark.parametrize("name", ["rrt", "kpiece", "est", "syclop_rrt", "syclop_est"])
def test_every_step_of_the_tree_and_of_the_lookahead_is_counted(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead, plain = [0], rollout.follow

    def listening(machine: Any, held: Any, h: float, states: Any) -> int:
        made: int = plain(machine, held, h, states)
        ahead[0] += min(made + 1, len(held))  # the one that failed, too
        return made

    monkeypatch.setattr(Listener, "heard", 0)
    monkeypatch.setattr(state_propagator, "Propagator", Listener)
    monkeypatch.setattr(rollout, "follow", listening)
    problem = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=0.001")
    settings = {} if name == "rrt" else {"goal_connection_period": 0}
    found = planners.get(name)(**settings).solve(problem, 1, Budget(60.0, 300))
    assert Listener.heard > 20
    assert (ahead[0] > 20) is (name != "rrt")  # OMPL alone chooses the inputs of that one
    assert found.statistics["propagations"] == Listener.heard + ahead[0]
    assert "goal_connections" not in found.statistics
