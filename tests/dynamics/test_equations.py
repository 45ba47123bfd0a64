"""The printed equations: their wording, and that they are what is compiled."""

from typing import Any

import numpy as np
import pytest
import sympy as sp

import kinolab.systems
from kinolab.dynamics import Model, rate
from kinolab.dynamics.symbols import Acceleration
from tests.dynamics.machines import compiled, compiled_random
from tests.dynamics.reference import Reference

PENDULUM = """\
L = m g l cos(θ) + 1/2 m l² θ̇²

d/dt(∂L/∂q̇) - ∂L/∂q = F + wᵀλ
  m l² θ̈ + m g l sin(θ) = torque"""

ROLLING_DISK = """\
L = 1/4 m R² φ̇² + 1/8 m R² ψ̇² + 1/2 m ẋ² + 1/2 m ẏ²

constraints
  -sin(ψ) ẋ + cos(ψ) ẏ = 0
  -R φ̇ + cos(ψ) ẋ + sin(ψ) ẏ = 0

d/dt(∂L/∂q̇) - ∂L/∂q = F + wᵀλ
  m ẍ = -λ₁ sin(ψ) + λ₂ cos(ψ)
  m ÿ = λ₁ cos(ψ) + λ₂ sin(ψ)
  1/4 m R² ψ̈ = steer
  1/2 m R² φ̈ = drive - R λ₂

reduced to the independent velocities
  1/4 m R² ψ̈ = steer
  3/2 m R² φ̈ = drive"""


@pytest.mark.parametrize(("name", "text"), [("pendulum", PENDULUM), ("rolling_disk", ROLLING_DISK)])
def test_the_printed_equations_are_those_of_the_textbook(name: str, text: str) -> None:
    import unicodedata

    printed = kinolab.systems.get(name).equations().text()
    plain = unicodedata.normalize("NFC", printed)
    assert plain == unicodedata.normalize("NFC", text)


def test_latex_has_dots_and_greek_letters() -> None:
    latex = kinolab.systems.get("rolling_disk").equations().latex()
    assert latex.startswith("$$L = ")
    assert r"\ddot{\psi} R^{2} m}{4} &= \mathrm{steer}" in latex
    assert latex.count(r"\begin{aligned}") == latex.count(r"\end{aligned}") == 3


def test_equations_are_a_sequence_of_balance_and_constraints() -> None:
    equations = kinolab.systems.get("rolling_disk").equations()
    assert len(equations) == 6
    assert list(equations) == [*equations.balance, *equations.constraints]
    assert all(isinstance(e, sp.Eq) for e in equations)
    assert len(equations.reduced) == 2  # psi_dot and phi_dot


MACHINES: dict[str, Any] = {
    "pendulum": lambda: kinolab.systems.get("pendulum").model(),
    "rolling_disk": lambda: kinolab.systems.get("rolling_disk").model(),
    "knife_edge": lambda: compiled("knife_edge"),
    "cart": lambda: compiled("cart"),
    "snakeboard": lambda: compiled("snakeboard"),
}
SMALL = [s for s in range(40) if compiled_random(s).nq <= 2][:6]
MACHINES |= {f"random {seed}": lambda seed=seed: compiled_random(seed) for seed in SMALL}


def numbers(model: Model, x: Any, u: Any, q_ddot: Any) -> dict[Any, float]:
    system = model.system
    named: dict[Any, float] = {p: system.parameter_values[p.name] for p in system.parameters}
    q_dot = model.velocity(x, u)
    for i, c in enumerate(system.coordinates):
        named |= {c: x[i], rate(c): q_dot[i], Acceleration(c): q_ddot[i]}
    return named | {entry.symbol: u[k] for k, entry in enumerate(system.inputs)}


def gap(equation: sp.Eq, named: dict[Any, float]) -> sp.Expr:
    return (equation.lhs - equation.rhs).xreplace(named)


@pytest.mark.parametrize("name", MACHINES)
def test_the_compiled_motion_satisfies_the_printed_equations(name: str) -> None:
    """The full accelerations follow from f by differences; lambda by least squares."""
    model = MACHINES[name]()
    equations = model.equations()
    rng = np.random.default_rng(11)
    reference = Reference(model.system)
    for _ in range(3):
        x, u = rng.uniform(-0.8, 0.8, model.nx), rng.uniform(-1, 1, model.nu)
        if name == "snakeboard":
            x[4:6] = 0.6, -0.4
        q, q_dot = x[: model.nq], model.velocity(x, u)
        q_ddot, _ = reference.multiplier_form(q, q_dot, u)  # dependent accelerations
        independent = list(model.independent)
        q_ddot[independent] = model.f(x, u)[model.nq :]
        named = numbers(model, x, u, q_ddot)
        multipliers = sp.symbols(f"lambda_1:{len(equations.constraints) + 1}", real=True)
        gaps = [gap(e, named) for e in equations.balance]
        rows = np.array([[float(g.coeff(s)) for s in multipliers] for g in map(sp.expand, gaps)])
        rest = np.array([float(g.xreplace(dict.fromkeys(multipliers, 0))) for g in gaps])
        if multipliers:
            solved = np.linalg.lstsq(rows, -rest, rcond=None)[0]
            rest = rest + rows @ solved
        scale = 1 + np.abs(q_ddot).max()
        assert np.abs(rest).max() < 1e-9 * scale  # [N] or [N m]
        for equation in (*equations.constraints, *equations.reduced):
            assert abs(float(gap(equation, named))) < 1e-9 * scale
        assert len(equations.reduced) in (0, len(independent))
        kinetic, potential = model.energy(x)
        lagrangian = float(equations.lagrangian.xreplace(named))
        assert lagrangian == pytest.approx(kinetic - potential, rel=1e-10, abs=1e-10)


def test_equations_are_in_the_authors_symbols() -> None:
    """m l^2 theta_ddot + m g l sin(theta) = torque, whatever the values of m, l and g."""
    system = kinolab.systems.get("pendulum")
    g, arm, m = system.parameters
    (theta,) = system.coordinates
    (equation,) = system.equations().balance
    expected = m * arm**2 * Acceleration(theta) + m * g * arm * sp.sin(theta)
    assert sp.expand(equation.lhs - expected) == 0
    assert equation.rhs == system.inputs[0].symbol
