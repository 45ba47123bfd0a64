"""What touches, by kinolab and by the benchmark's own code, on random states."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from tests.scenario.dynobench.wheel import ENVIRONMENTS, environment, needs_wheel, room

STATES = 200
TOUCHING = 2e-7  # [m]: kinolab inflates bodies by 1e-7 m, for it calls touching a collision
FAILURES = 0.03  # share of states about which the benchmark's FCL has no answer

pytestmark = needs_wheel


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_what_touches_is_what_the_benchmark_says(name: str) -> None:
    problem = kinolab.load(environment(name))
    if not problem.scenario.world.obstacle:
        pytest.skip("there are no obstacles")
    random = np.random.default_rng(0)
    x = random.uniform(*problem.sampling_bounds.T, (STATES, problem.model.nx))
    for first in problem.model.attitudes.values():
        q = random.normal(size=(STATES, 4))
        x[:, first : first + 4] = q / np.linalg.norm(q, axis=1, keepdims=True)
    checker = problem.checker()
    ours = np.array([checker.collides(*problem.placement(state)) for state in x])
    official = room(problem.system.name, environment(name), x)
    failed = np.isnan(official)
    assert failed.mean() <= FAILURES
    assert ours[failed].all()  # it fails where boxes overlap deeply, and nowhere else
    clear = np.abs(official) > TOUCHING
    np.testing.assert_array_equal(ours[clear], official[clear] < 0)
