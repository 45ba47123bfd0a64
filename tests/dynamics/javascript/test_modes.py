"""Machines with modes in another engine: they switch when and how the compiled ones do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import System
from tests.javascript_engine import Engine
from tests.switching_machines import ball, compass_walker, hopper

DT = 0.01  # [s]

COMPASS = [0.2, 0.97, 0.22, -0.33, -1.07, -0.22, -1.1, -0.4, 0.0]
BIPED = {"z": 0.95103, "hip_left": 0.2, "hip_right": -0.2, "knee_left": -0.2, "knee_right": -0.2}


def walking() -> System:
    return systems.get("biped")


def start_of(name: str, states: tuple[str, ...]) -> np.ndarray:
    match name:
        case "ball":
            return np.array([0.6, 0.0, 0.0])
        case "hopper":
            return np.array([0.9, 0.0, -2.0, -2.0, 1.0])
        case "compass_walker":
            return np.array(COMPASS)
    return np.array([BIPED.get(state, 0.0) for state in states])


@pytest.mark.parametrize(
    ("make", "u", "switches"),
    [(ball, [], 3), (hopper, [], 3), (compass_walker, [], 1), (walking, [0, 0.1, 0.8, 0, 0], 1)],
)
def test_it_switches_as_compiled(
    make: Callable[[], System], u: list[float], switches: int, engine: Engine
) -> None:
    """Differences grow by what a motion makes of rounding, and by an impact at another instant."""
    made = make().model()
    machine = engine.machine(made)
    x = start_of(made.system.name, made.state_names)
    path = [x]
    for _ in range(150):
        path.append(made.step(path[-1], u, DT))
    found = np.array(engine.run(
        f"""let x = a; const path = [x];
        for (let k = 0; k < 150; k++) path.push(x = Array.from({machine}.step(x, b, {DT})));
        return path""", x.tolist(), u,
    ))  # fmt: skip
    modes = np.array(path)[:, -1]
    falls = np.diff(np.array(path)[:, made.nq]) if make is ball else np.diff(modes)
    assert np.count_nonzero(np.abs(falls) > 0.5) >= switches
    assert (found[:, -1] == modes).all()
    assert np.abs(found - path).max() < 1e-9
    poses = engine.run(f"return Array.from({machine}.frames(a))", path[-1].tolist())
    assert np.abs(np.array(poses) - made.frames(path[-1]).ravel()).max() < 1e-12
