"""A quadruped on a stand is planned for without a word about its integration."""

from __future__ import annotations

import pytest

import kinolab
from kinolab.simulation import stiffness
from tests.robots.test_urdf import FOLDER
from tests.support import failed, needs

GO1 = FOLDER / "go1_description" / "urdf" / "go1.urdf"
STANDING = {"hip": 0.0, "thigh": 0.8, "calf": -1.6}
LIFTED = {"hip": 0.0, "thigh": -0.1, "calf": -1.0}


def posed(**legs: dict[str, float]) -> dict[str, float]:
    """Return the angles of all legs, those that are named in other poses than standing."""
    poses = dict.fromkeys(("FR", "FL", "RR", "RL"), STANDING) | legs
    return {f"{leg}_{part}_joint": q for leg, pose in poses.items() for part, q in pose.items()}


@needs("yourdfpy")
@pytest.mark.skipif(not GO1.is_file(), reason="needs example-robot-data")
def test_a_quadruped_on_a_stand_lifts_a_leg_past_a_bar() -> None:
    """Dry friction of 0.2 N m within 0.01 rad/s is stiff, and 35 N m turn a light leg quickly."""
    bar = {"name": "bar", "box": [0.03, 0.3, 0.03], "position": [0.24, -0.13, -0.30]}
    problem = kinolab.load(
        {
            "system": {"file": str(GO1)},
            "world": {"obstacle": [bar]},
            "start": posed(),
            "goal": {**posed(FR=LIFTED), "at_rest": True},
        }
    )
    assert stiffness(problem) is None
    plan = problem.solve(seed=1, improve=0, time_limit=300.0)  # on a busy computer
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert not failed(plan.certificate)
    end = dict(zip(problem.model.state_names, plan.trajectory.x[-1], strict=True))
    for name, q in posed(FR=LIFTED).items():
        assert end[name] == pytest.approx(q, abs=0.05)  # [rad]
