"""Asks the authors' own code, in a process of its own: it prints, and it may hang.

    python official.py QUESTION ROBOT ENVIRONMENT IN.npz OUT.npz

QUESTION is steps (x, u, dt), distances (x, y), bounds, room (x), or check (states, actions, times,
start, goal). The answer to room is written row by row, for FCL may hang on boxes that overlap
deeply. Then the process ends by a signal, before it has answered about that state.
"""

import signal
import sys
from pathlib import Path

import dynobench
import numpy as np

STUCK = 0.3  # [s] of this process's time for one state, which takes less than a millisecond


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
    elif question == "check":
        found = {name: np.array(value) for name, value in _check(official, asked).items()}
    else:
        _room(official, asked["x"], Path(answer))
        return
    np.savez(answer, **found)


def _check(official: dynobench.Model_robot, asked: dict[str, np.ndarray]) -> dict[str, float]:
    """Return what the benchmark's checker judges a trajectory by, apart from collisions.

    All jumps are looked at: ``Trajectory::check`` itself leaves them out where it is not verbose.
    """
    x, u = asked["states"], asked["actions"]
    reached = [official.stepOut(a, b, float(asked["dt"])) for a, b in zip(x[:-1], u, strict=True)]
    return {
        "start": official.distance(x[0], asked["start"]),
        "goal": official.distance(x[-1], asked["goal"]),
        "jump": max(official.distance(a, b) for a, b in zip(reached, x[1:], strict=True)),
        "states": _beyond(x, official.get_x_lb(), official.get_x_ub()),
        "actions": _beyond(u, official.get_u_lb(), official.get_u_ub()),
    }


def _beyond(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """Return by how much values pass their limits at most."""
    return float(max((lower - values).max(), (values - upper).max()))


def _room(official: dynobench.Model_robot, states: np.ndarray, answer: Path) -> None:
    """Write the signed distance to obstacles in [m] of one state after the other."""
    out = dynobench.CollisionOut()
    with answer.open("w") as file:
        for x in states:
            signal.setitimer(signal.ITIMER_PROF, STUCK)  # nobody catches it: it ends the process
            try:
                official.collision_distance(x, out)
                file.write(f"{out.distance!r}\n")
            except RuntimeError:  # boxes that overlap deeply, too
                file.write("nan\n")
            file.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
