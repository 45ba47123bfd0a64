"""A plan in the benchmark's own format, for its checker and its tables."""

from __future__ import annotations

import numpy as np
import yaml

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory


def has_its_steps(problem: PlanningTask, trajectory: Trajectory) -> bool:
    """Whether every step of a trajectory is as long as the benchmark's, which knows no others."""
    steps = np.diff(trajectory.t)
    # 1e-9 [s] by which a step may differ from the benchmark's, rounding of times
    return bool(np.abs(steps - problem.step).max(initial=0.0) <= 1e-9)


def result_text(problem: PlanningTask, trajectory: Trajectory) -> str:
    """Return a trajectory as YAML: states (N+1 rows), actions (N rows), times and the cost in [s].

    Angles on circles lie in [-pi, pi), as the benchmark has them; 17 digits are written.
    Its steps must be the benchmark's: ``has_its_steps``.
    """
    states = np.where(problem.model.circular, wrapped(trajectory.x), trajectory.x)
    content = {
        "cost": trajectory.duration,
        "start": problem.start.tolist(),
        "goal": problem.goal.centre(problem.start).tolist(),
        "num_states": len(states),
        "states": states.tolist(),
        "num_actions": len(trajectory.u),
        "actions": trajectory.u.tolist(),
        "num_times": len(states),
        "times": trajectory.t.tolist(),
    }
    text: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None)
    return text
