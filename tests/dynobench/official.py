"""Asks the benchmark's own code, in a process of its own: it prints, and it may hang.

    python official.py QUESTION ROBOT ENVIRONMENT IN.npz OUT.npz

QUESTION is steps (x, u, dt), distances (x, y), bounds, or room (x). The answer to room is written
row by row, for FCL may hang on boxes that overlap deeply: whoever asks must set a time limit.
"""

import sys
from pathlib import Path

import dynobench
import numpy as np


def main(question: str, robot: str, environment: str, given: str, answer: str) -> None:
    """Answer one question; ``robot`` is the stem of a model file."""
    model = Path(dynobench.__file__).parent / "models" / f"{robot}.yaml"
    official = dynobench.robot_factory_with_env(str(model), environment)
    asked = dict(np.load(given))
    if question == "steps":
        rows = zip(asked["x"], asked["u"], strict=True)
        found = {"x": np.array([official.stepOut(x, u, float(asked["dt"])) for x, u in rows])}
    elif question == "distances":
        rows = zip(asked["x"], asked["y"], strict=True)
        found = {"distance": np.array([official.distance(x, y) for x, y in rows])}
    elif question == "bounds":
        names = ("x_lb", "x_ub", "u_lb", "u_ub")
        found = {name: np.array(getattr(official, f"get_{name}")()) for name in names}
    else:
        _room(official, asked["x"], Path(answer))
        return
    np.savez(answer, **found)


def _room(official: dynobench.Model_robot, states: np.ndarray, answer: Path) -> None:
    """Write the signed distance to obstacles in [m] of one state after the other."""
    out = dynobench.CollisionOut()
    with answer.open("w") as file:
        for x in states:
            official.collision_distance(x, out)
            file.write(f"{out.distance!r}\n")
            file.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
