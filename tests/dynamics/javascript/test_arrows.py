"""Arrows of constraint forces, judged by Newton's laws."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.dynamics.javascript.machines import inputs, model
from tests.javascript_engine import Engine

Array = NDArray[np.float64]

H = 1e-4  # [s], for differences of second order

# Machines that only their wheels' contacts push along the ground, in motion.
MOVING = {
    "rolling_disk": {"psi": 0.4, "psi_dot": 0.7, "phi_dot": 3.0},
    "diff_drive": {"psi": 0.3, "phi_l_dot": 2.0, "phi_r_dot": 4.0},
    "snakeboard": {"theta": 0.2, "phi": 0.3, "s_dot": 20.0, "phi_dot": 0.5},
    "car": {"psi": 0.3, "delta": 0.2, "phi_dot": 6.0},
}
WITHOUT_DRAG = {"snakeboard": {"c_r": 0.0}}


def moving(name: str) -> Array:
    made = model(name)
    x = made.rest()
    for entry, value in MOVING[name].items():
        if entry in made.state_names:
            x[made.state_names.index(entry)] = value
    return x


def arrows(engine: Engine, name: str, x: Array, u: Array, **parameters: float) -> list[Any]:
    p = model(name).parameter_vector(**parameters)
    given = (array.tolist() for array in (x, u, p))
    found: list[Any] = engine.run(f"return {engine.machine(model(name))}.arrows(a, b, c)", *given)
    return found


@pytest.mark.parametrize("name", list(MOVING))
def test_forces_of_constraints_accelerate_the_machine_along_the_ground(
    name: str, engine: Engine
) -> None:
    """Newton's second law: they add up to the change of momentum, by differences of positions."""
    made, x, u = model(name), moving(name), inputs(name, 1, 0.5)[0]
    values = WITHOUT_DRAG.get(name, {})
    masses = np.array([made.system.number(body.mass) for body in made.system.bodies])
    places = [masses @ made.frames(made.step(x, u, dt, **values))[:, 3::4] for dt in (-H, 0.0, H)]
    expected = (places[0] - 2 * places[1] + places[2]) / H**2
    found = np.sum([arrow["force"] for arrow in arrows(engine, name, x, u, **values)], axis=0)
    assert np.linalg.norm(expected[:2]) > 0.1  # [N], so that there is something to explain
    np.testing.assert_allclose(found[:2], expected[:2], rtol=1e-4, atol=1e-6 * masses.sum())


def test_a_coin_is_held_where_it_touches_the_ground(engine: Engine) -> None:
    x = moving("rolling_disk")
    x[:2] = 1.5, -0.5
    for arrow in arrows(engine, "rolling_disk", x, np.zeros(2)):
        np.testing.assert_allclose(arrow["at"], [1.5, -0.5, 0.0], atol=1e-6)
        np.testing.assert_allclose(arrow["torque"], 0.0, atol=1e-6)


def test_a_leaning_coin_is_held_where_it_touches_the_ground(engine: Engine) -> None:
    """That point is on the coin, below its centre and R sin(lean) beside it."""
    made = model("falling_disk")
    x = made.rest()
    x[made.state_names.index("theta")] = 0.3
    x[made.state_names.index("phi_dot")] = 2.0
    centre = made.frames(x)[0, 3::4]
    R = made.system.parameter_values["R"]
    for arrow in arrows(engine, "falling_disk", x, np.zeros(made.nu)):
        assert arrow["at"][2] == pytest.approx(0.0, abs=1e-6)
        assert np.linalg.norm(np.subtract(arrow["at"], centre)) == pytest.approx(R, rel=1e-6)


def test_every_wheel_of_a_robot_is_held_below_its_axle(engine: Engine) -> None:
    x = moving("diff_drive")
    made = model("diff_drive")
    by_name = {a["name"]: a for a in arrows(engine, "diff_drive", x, np.array([0.3, 0.1]))}
    for index, name in ((1, "left wheel rolls"), (2, "right wheel rolls")):
        below = made.frames(x)[index, 3::4] * [1, 1, 0]
        np.testing.assert_allclose(by_name[name]["at"], below, atol=1e-6)
