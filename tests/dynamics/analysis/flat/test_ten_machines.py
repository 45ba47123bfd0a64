"""Ten machines of textbooks are found flat, or not flat, as the literature has it."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from kinolab.dynamics import System
from kinolab.dynamics.analysis.flatness_of import Flatness
from tests.flat_machines import TEN, Answer, gantry_with_hoist, pvtol, quadrotor_with_pendulum

NAMES = [answer.machine.__name__ for answer in TEN]


@pytest.mark.parametrize("answer", TEN, ids=NAMES)
def test_what_is_said_is_what_the_literature_says(answer: Answer) -> None:
    found = answer.machine().flatness()
    assert found.flatness is (Flatness.FLAT if answer.flat else Flatness.NOT_FLAT), answer.source
    assert tuple(one.order for one in found.outputs) == answer.orders
    assert bool(found.reason) == (not answer.flat)


def test_a_pvtols_output_is_huygens_centre_of_oscillation() -> None:
    """Martin, Devasia, Paden: J / (m l) from the centre of mass, away from the lateral force."""
    m, J, l = 2.0, 0.5, 0.4  # noqa: E741
    x, z, theta = sympy.symbols("x z theta")
    wanted = (x + J / (m * l) * sympy.sin(theta), z + J / (m * l) * sympy.cos(theta))
    _same(pvtol(), wanted)


def test_of_a_quadrotor_with_a_rod_it_is_the_rods_centre_of_oscillation_about_its_hinge() -> None:
    m, J, c = 0.4, 0.03, 0.5
    reach = (J + m * c**2) / (m * c)
    x, z, phi = sympy.symbols("x z phi")
    wanted = (x - reach * sympy.sin(phi), z - reach * sympy.cos(phi))
    _same(quadrotor_with_pendulum(), wanted)


def test_a_gantry_that_also_hoists_is_flat_by_its_load() -> None:
    found = gantry_with_hoist().flatness()
    assert str(found) == (
        "flat: x and z of the centre of mass of load, to their 6th derivatives (found)"
    )


def test_a_proof_repeats_to_the_last_bit() -> None:
    assert pvtol().flatness().margin == pvtol().flatness().margin


def _same(system: System, wanted: tuple[sympy.Expr, ...]) -> None:
    """Compare formulas at random places; coordinates are matched by name."""
    generator = np.random.default_rng(0)
    for one, other in zip(system.flatness().outputs, wanted, strict=True):
        for _ in range(5):
            values = {c.name: float(generator.uniform(-1, 1)) for c in system.coordinates}
            first, second = (
                float(e.subs({s: values[s.name] for s in e.free_symbols}))
                for e in (one.expression, other)
            )
            assert first == pytest.approx(second, abs=1e-9)  # [m] of an offset of 12 digits
