"""The second derivation keeps its digits for machines of milligrams, and of thousand tons."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Force, System, length, move, zero
from kinolab.dynamics.language.frames import velocity
from kinolab.dynamics.model.second_derivation import SecondDerivation

SIZES = [(1e-6, 1e-3), (1e-9, 1e-4), (1e-12, 1e-5), (1e6, 50.0)]  # [kg], [m]


@pytest.mark.parametrize(("mass", "radius"), SIZES)
def test_an_upright_coin_turns_by_its_torques_over_its_inertias(mass: float, radius: float) -> None:
    """phi'' = drive / (3/2 m R^2), psi'' = steer / (1/4 m R^2): it neither slips nor slides."""
    model = kinolab.systems.get("rolling_disk", m=mass, R=radius).model()
    x = np.array([[0.0, 0.0, 0.7, 0.2, 1.5, -2.0], [0.1, 0.2, -1.0, 3.0, 0.0, 4.0]])
    u = np.array([[0.6, -0.2], [-1.0, 0.5]])
    found = SecondDerivation(model).derivative(x, u)
    psi, phi = (model.state_names.index(name) for name in ("psi_dot", "phi_dot"))
    drive, steer = (model.control_names.index(name) for name in ("drive", "steer"))
    assert found[:, phi] == pytest.approx(u[:, drive] / (1.5 * mass * radius**2), rel=1e-9)
    assert found[:, psi] == pytest.approx(u[:, steer] / (0.25 * mass * radius**2), rel=1e-9)
    assert found[:, :2] == pytest.approx(
        radius * x[:, [phi]] * np.column_stack([np.cos(x[:, 2]), np.sin(x[:, 2])]), rel=1e-9
    )


@pytest.mark.parametrize("ratio", [1e-3, 1e-8, 1e-13])
def test_a_mote_that_is_towed_takes_its_share_of_the_push(ratio: float) -> None:
    """Both move as one: x'' = F / (1 + ratio), whichever of them is pushed."""
    x, y = length("x", speed=9.0), length("y", speed=9.0)
    truck, mote = Body("truck", move(x, 0, 0), mass=1.0), Body("mote", move(y, 1, 0), mass=ratio)
    for pushed in (truck, mote):
        system = System(
            "tow",
            bodies=[truck, mote],
            constraints=[zero(velocity(mote.frame).x - velocity(truck.frame).x, "towed")],
            inputs=[Force("push", on=pushed, along=pushed.frame.x, limit=9.0)],
        )
        model = system.model()
        found = SecondDerivation(model).derivative(np.zeros((1, model.nx)), np.array([[3.0]]))
        assert found[0, -1] == pytest.approx(3.0 / (1.0 + ratio), rel=1e-12)
