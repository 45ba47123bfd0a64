"""Magnets are a force of one class outside the package, and obey the laws of all others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from kinolab.dynamics import (
    Body,
    Capsule,
    System,
    Torque,
    angle,
    length,
    move,
    orient,
    parameter,
    rot_y,
    rotation,
)
from kinolab.dynamics.language.forces import Potential
from tests.extension import laws
from tests.extension.magnet import PERMEABILITY, Magnets

Array = NDArray[np.float64]

MASS, INERTIA = 0.02, (2e-5, 3e-5, 4e-5)  # [kg], [kg m^2]
MOMENTS = (4.0, 2.5)  # [A m^2]
FAR = 0.12  # [m]

SWING = """\
schema = 1
title = "A needle turns away from a magnet"
[system]
file = "machine.py:compass"
[goal]
theta = 2.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.02
[render]
size = [160, 120]
[planner]
improve = 0
name = "prm"
time_limit = 60.0
"""


def floating() -> System:
    """A magnet that floats freely near one that is fixed at the origin."""
    x, y, z, R = length("x"), length("y"), length("z"), rotation("R")
    frame = move(x, y, z) @ orient(R)
    body = Body("magnet", frame, mass=MASS, inertia=INERTIA, shape=Capsule(0.004, 0.02))
    strength = parameter("m_1", MOMENTS[0], "A m^2")
    pull = Magnets(between=(move(0, 0, 0), frame), moments=(strength, MOMENTS[1]))
    return System("floating_magnet", bodies=[body], efforts=[pull])


def compass() -> System:
    """A needle on a pivot, with a motor, before a magnet that is fixed."""
    theta = angle("theta", speed=20.0)
    needle = rot_y(theta)
    body = Body("needle", needle, mass=MASS, inertia=INERTIA, shape=Capsule(0.004, 0.05))
    return System(
        "compass",
        bodies=[body],
        inputs=[Torque("motor", on=body, about=needle.y, limit=5e-3)],
        efforts=[Magnets(between=(move(0, 0, FAR), needle), moments=MOMENTS)],
    )


def states(count: int = 6) -> Array:
    """Of the floating magnet, a decimetre away."""
    random = np.random.default_rng(7)
    places = random.normal(size=(count, 3))
    places *= 0.1 / np.linalg.norm(places, axis=1, keepdims=True)
    turns = Rotation.random(count, random_state=3).as_quat()
    return np.hstack([places, turns, random.normal(scale=0.2, size=(count, 6))])


def needles(count: int = 6) -> Array:
    return np.random.default_rng(5).uniform(-3, 3, (count, 2))


def test_force_and_torque_are_those_of_dipoles() -> None:
    """m_2 x B_1 on the magnet; its force is that of Yung, Landecker, Villani 1998.

    Source: Yung, Landecker, Villani, An analytic solution for the force between two magnetic
    dipoles, Magnetic and Electrical Separation 9(1), 1998.
    """
    model = floating().model()
    for x in states():
        turn = Rotation.from_quat(x[3:7]).as_matrix()
        path, one, other = x[:3], np.array([0, 0, MOMENTS[0]]), MOMENTS[1] * turn[:, 2]
        r = np.linalg.norm(path)
        n = path / r
        force = one * (other @ n) + other * (one @ n) + n * (one @ other)
        force = 3 * PERMEABILITY / r**4 * (force - 5 * n * (one @ n) * (other @ n))
        field = PERMEABILITY / r**3 * (3 * n * (one @ n) - one)
        torque, inertia, spin = turn.T @ np.cross(other, field), np.array(INERTIA), x[10:]
        turning = (torque - np.cross(spin, inertia * spin)) / inertia
        np.testing.assert_allclose(model.f(x)[7:10], force / MASS, rtol=1e-10)
        np.testing.assert_allclose(model.f(x)[10:], turning, rtol=1e-10)
        energy = PERMEABILITY / r**3 * (one @ other - 3 * (one @ n) * (other @ n))
        assert model.energy(x)[1] == pytest.approx(energy, rel=1e-12)


def test_a_needle_before_a_magnet_is_a_pendulum() -> None:
    """theta_ddot = -2 mu_0 m_1 m_2 sin(theta) / (4 pi r^3 I) without the motor."""
    model = compass().model()
    for x in needles():
        pull = -2 * PERMEABILITY * MOMENTS[0] * MOMENTS[1] * np.sin(x[0]) / FAR**3
        assert model.f(x, [1e-3])[1] == pytest.approx((pull + 1e-3) / INERTIA[1], rel=1e-12)


def test_a_magnet_keeps_its_energy() -> None:
    model, start = floating().model(), states()[0]
    solved = solve_ivp(lambda _, x: model.f(x), (0, 0.05), start, "DOP853", rtol=1e-12, atol=1e-14)
    energies = np.sum(model.energy(np.ascontiguousarray(solved.y.T)), axis=0)
    assert np.ptp(energies) < 1e-9 * np.abs(energies).max()
    assert np.ptp(model.energy(np.ascontiguousarray(solved.y.T))[1]) > 1e-6 * energies.max()


def test_both_derivations_agree() -> None:
    laws.both_derivations_agree(floating(), states())
    laws.both_derivations_agree(compass(), needles())


def test_the_page_computes_it() -> None:
    laws.the_page_computes_it(compass(), needles(3))


def test_its_file_has_an_energy_in_its_place() -> None:
    back = laws.its_file_tells_it_without_its_code(compass(), needles())
    assert [type(effort) for effort in back.efforts] == [Potential]
    laws.its_file_tells_it_without_its_code(floating(), states())


def test_a_plan_is_certified_and_shown(tmp_path: Path) -> None:
    source = "from tests.extension.test_magnet import compass\n"
    laws.a_plan_is_certified_and_shown(tmp_path, source, SWING)
