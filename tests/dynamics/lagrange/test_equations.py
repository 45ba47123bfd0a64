"""The printed equations: their wording, and that they are what is compiled."""

import re
import time
import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

import kinolab.systems
from kinolab.dynamics import (
    Body,
    Model,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
)
from kinolab.dynamics.lagrange.equations import Equations
from kinolab.dynamics.language.mechanism_parts import configuration_symbols, tangent_symbols
from kinolab.dynamics.symbols.symbols import Acceleration, TurnAcceleration, TurnRate
from kinolab.errors import InputError
from tests import registered
from tests.dynamics.machines import compiled, compiled_random
from tests.dynamics.reference import Reference

# Equations of 200 000 operations take SymPy two minutes; those of the bicycle half a one.
LONGEST = ("marionette", "whipple")
PRINTED = [pytest.param(n, marks=pytest.mark.long) if n in LONGEST else n for n in registered.NAMES]

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
    printed = kinolab.systems.get(name).equations().text()
    plain = unicodedata.normalize("NFC", printed)
    assert plain == unicodedata.normalize("NFC", text)


def test_latex_has_dots_and_greek_letters() -> None:
    latex = kinolab.systems.get("rolling_disk").equations().latex()
    assert latex.startswith("$$L = ")
    assert r"\frac{1}{4} m R^{2} \ddot{\psi} &= \mathrm{steer}" in latex
    assert r"\frac{3}{2} m R^{2} \ddot{\phi} &= \mathrm{drive}" in latex
    assert latex.count(r"\begin{aligned}") == latex.count(r"\end{aligned}") == 3


def test_a_notebook_shows_them_as_one_formula() -> None:
    shown = kinolab.systems.get("rolling_disk").equations()._repr_latex_()
    assert shown.count("$$") == 2
    assert shown.startswith(r"$$\begin{gathered}L = ")
    assert shown.count(r"\begin{aligned}") == shown.count(r"\end{aligned}") == 3


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
SMALL = (11, 14, 21, 23, 24, 27)  # with at most two coordinates
MACHINES |= {f"random {seed}": lambda seed=seed: compiled_random(seed) for seed in SMALL}


@pytest.mark.parametrize("seed", SMALL)
def test_small_machines_are_small(seed: int) -> None:
    assert compiled_random(seed).nq <= 2


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


# --- the machines of the library ---

REDUCED = {
    "car": """\
  J_s δ̈ + J_s R tan(δ) φ̈/L + J_s R δ̇ φ̇/(L cos²(δ)) = steer - c_s δ̇
  J_s R tan(δ) δ̈/L + (I_w + m R² + R² tan²(δ) (I_z + J_s + m a²)/L²) φ̈
      + R² tan(δ) (I_z + J_s + m a²) δ̇ φ̇/(L² cos²(δ)) = drive - c_d φ̇""",
    "snakeboard": """\
  J_r ψ̈ - 0.04 J_r sin(φ) s̈/l - 0.04 J_r cos(φ) φ̇ ṡ/l = τ_psi - c_psi ψ̇
  2 J_w φ̈ = τ_phi - c_phi φ̇
  -0.04 J_r sin(φ) ψ̈/l + (I_s + 0.0016 m) s̈ = -0.0032 c_r ṡ""",
    "diff_drive": """\
  (I_w + I_z r²/b² + 1/4 m r²) φ̈_l + r² (-I_z/b² + 1/4 m) φ̈_r = left - c_w φ̇_l
  r² (-I_z/b² + 1/4 m) φ̈_l + (I_w + I_z r²/b² + 1/4 m r²) φ̈_r = right - c_w φ̇_r""",
}
CRANE = """\
  m sin(θ_y) l̈ + m l cos(θ_y) θ̈_y + (M_t + m) ÿ - m l sin(θ_y) θ̇_y² + 2 m cos(θ_y) l̇ θ̇_y
      = traverse - c_y ẏ
  m l̈ + m cos(θ_y) sin(θ_x) ẍ + m sin(θ_y) ÿ - m l cos²(θ_y) θ̇_x² - m l θ̇_y²
      - m g cos(θ_x) cos(θ_y) = -hoist - c_l l̇"""


@cache
def machine(name: str) -> System:
    """One of its kind: two machines of a name have coordinates of their own."""
    return registered.MAKERS[name]()


@cache
def equations_of(name: str) -> Equations:
    return machine(name).equations()


def plain(text: str) -> str:
    return unicodedata.normalize("NFC", text)


@pytest.mark.parametrize("name", REDUCED)
def test_constrained_machines_are_printed_as_they_are_simulated(name: str) -> None:
    """In the independent velocities alone, without multipliers and dependent coordinates."""
    text = plain(equations_of(name).text())
    assert text.endswith(plain("reduced to the independent velocities\n" + REDUCED[name]))


def test_the_crane_is_printed_as_on_the_blackboard() -> None:
    """The rope's length does not stand beside its own absolute value, and one is no 1.0."""
    assert plain(CRANE) in plain(equations_of("crane").text())


@pytest.mark.parametrize("name", PRINTED)
def test_printed_equations_are_short_lines_of_what_is_needed(name: str) -> None:
    equations = equations_of(name)
    text = equations.text()
    assert re.search(r"(?<![\d.])\d+\.0(?!\d)", text) is None  # 1.0 m
    assert "/Abs(l)" not in text
    assert "α̈/(2)" not in text
    limit = 110 if name == "whipple" else 100  # its longest factor has no place for a break
    assert max(map(len, text.splitlines())) <= limit
    squares = r"(\S+ )?sin²(\(\w+\)) \+ \1?cos²\2"
    found = re.search(squares, text) if name != "whipple" else None
    assert found is None, found


def values_at(model: Model, x: Any, u: Any) -> dict[Any, float]:
    """Every symbol of the printed equations at a state, from the compiled model."""
    system, h = model.system, 1e-5
    slope = model.f(x, u)
    rates = model.velocity(x, u)
    ahead, behind = (model.velocity(x + sign * h * slope, u) for sign in (1, -1))
    changes = (ahead - behind) / (2 * h)  # of dependent rates; the others follow exactly
    changes[list(model.independent)] = slope[model.nq : model.nq + len(model.independent)]
    named: dict[Any, float] = {p: system.parameter_values[p.name] for p in system.parameters}
    named |= dict(zip(configuration_symbols(system), x, strict=False))
    for v, value, change in zip(tangent_symbols(system), rates, changes, strict=True):
        acceleration = (
            TurnAcceleration(v) if isinstance(v, TurnRate) else Acceleration(v.coordinate)
        )
        named |= {v: value, acceleration: change}
    further = len(system.states)
    if further:
        for entry, value, change in zip(system.states, x[-further:], slope[-further:], strict=True):
            named |= {entry.symbol: value, sp.Symbol(f"{entry.name}_dot", real=True): change}
    return named | {entry.symbol: u[k] for k, entry in enumerate(system.inputs)}


def sides(equations: Sequence[sp.Eq], symbols: Iterable[Any], free: Sequence[Any] = ()) -> Any:
    """Left and right sides as functions of all symbols' values, shape (2, equations)."""
    expressions = [[e.lhs for e in equations], [e.rhs for e in equations]]
    made = sp.lambdify([*symbols, *free], expressions, "numpy", cse=True)
    return lambda *values: np.array(made(*values), dtype=float)


ROUNDING = 1e-9  # relative to both sides
DIFFERENCES = 1e-6  # the same, where dependent accelerations are differences


@pytest.mark.parametrize("name", PRINTED)
def test_all_that_is_printed_of_a_machine_is_what_its_model_does(name: str) -> None:
    equations = equations_of(name)
    model = machine(name).model().plant
    rng, count = np.random.default_rng(5), len(model.system.constraints)
    multipliers = sp.symbols(f"lambda_1:{count + 1}", real=True)
    symbols = tuple(values_at(model, model.rest(), model.control_bounds.mean(axis=1)))
    others = sides((*equations.reduced, *equations.constraints, *equations.further), symbols)
    balance = sides(equations.balance, symbols, multipliers)
    for _ in range(2):
        x, u = model.rest(), rng.uniform(*model.control_bounds.T)
        x = x + rng.uniform(-0.3, 0.3, model.nx) * np.minimum(model.state_scales, 2.0)
        x = np.clip(x, *model.state_bounds.T)
        for _ in range(20):  # on the constraints
            x = model.project(x)
        named = values_at(model, x, u)
        values = [named[symbol] for symbol in symbols]
        left, right = others(*values)
        assert (abs(left - right) <= ROUNDING * (1 + abs(left) + abs(right))).all()
        if not equations.balance:
            continue
        left, right = balance(*values, *np.zeros(count))
        gaps = left - right
        if count:
            rows = [np.subtract(*balance(*values, *unit)) - gaps for unit in np.eye(count)]
            gaps += np.transpose(rows) @ np.linalg.lstsq(np.transpose(rows), -gaps, rcond=None)[0]
        limit = DIFFERENCES if count else ROUNDING
        assert (abs(gaps) <= limit * (1 + abs(left) + abs(right))).all()
        kinetic, potential = model.energy(x, u)
        lagrangian = float(equations.lagrangian.xreplace(named))
        assert lagrangian == pytest.approx(kinetic - potential, rel=1e-9, abs=1e-9)


HAND = ("car", "motorcycle", "snakeboard", "unicycle", "falling_disk", "diff_drive", "rolling_disk")


@pytest.mark.parametrize("name", HAND)
def test_reduced_equations_alone_give_the_accelerations_of_the_model(name: str) -> None:
    """Solved for the independent accelerations, which they are linear in."""
    model, equations = machine(name).model().plant, equations_of(name)
    tangent = tangent_symbols(model.system)
    unknown = [Acceleration(tangent[i].coordinate) for i in model.independent]
    gaps = [sp.expand(e.lhs - e.rhs) for e in equations.reduced]
    assert len(gaps) == len(unknown)
    rng = np.random.default_rng(9)
    for _ in range(3):
        x = np.clip(rng.uniform(-0.5, 0.5, model.nx), *model.state_bounds.T)
        u = rng.uniform(*model.control_bounds.T)
        named = values_at(model, x, u)
        known = {symbol: value for symbol, value in named.items() if symbol not in unknown}
        rows = [[float(g.coeff(a).xreplace(known)) for a in unknown] for g in gaps]
        rest = [float(g.xreplace(dict.fromkeys(unknown, 0)).xreplace(known)) for g in gaps]
        expected = model.f(x, u)[model.nq :]
        np.testing.assert_allclose(-np.linalg.solve(rows, rest), expected, rtol=1e-8, atol=1e-8)


def test_the_motorcycle_leans_by_the_equation_of_its_source() -> None:
    """Getz, Marsden 1995: p a'' = g sin a + (1 + p s sin a) s v^2 cos a + c cos a d/dt(v s).

    Here s = tan(delta) / b is the track's curvature and v = R phi_dot.
    """
    system = machine("motorcycle")
    symbol = {p.name: p for p in system.parameters} | {c.name: c for c in system.coordinates}
    m, g, p, c, b, R = (symbol[name] for name in ("m", "g", "p", "c", "b", "R"))
    alpha, delta, phi = (symbol[name] for name in ("alpha", "delta", "phi"))
    v, s = R * rate(phi), sp.tan(delta) / b
    turn = R * Acceleration(phi) * s + v * rate(delta) / (b * sp.cos(delta) ** 2)
    right = g * sp.sin(alpha) + (1 + p * s * sp.sin(alpha)) * s * v**2 * sp.cos(alpha)
    right += c * sp.cos(alpha) * turn
    lean = equations_of("motorcycle").reduced[0]
    difference = m * p * (p * Acceleration(alpha) - right) - (lean.lhs - lean.rhs)
    assert sp.simplify(difference) == 0


def test_friction_along_a_chain_of_frames_keeps_its_sums_of_angles() -> None:
    """A trailer's drag is -c V^2 along its own axis, a + psi from the world's."""
    x, y, psi, a = length("x"), length("y"), angle("psi"), angle("a")
    c = parameter("c", 1.0, "N s/m")
    car = move(x, y) @ rot_z(psi)
    trailer = car @ rot_z(a) @ move(-1.2, 0, 0)
    bodies = [Body("car", car, mass=80, inertia=10), Body("trailer", trailer, mass=40, inertia=5)]
    drag = [Viscous(velocity(car).x, c), Viscous(velocity(trailer).x, c)]
    printed = System("pair", bodies=bodies, efforts=drag).equations().text()
    text = unicodedata.normalize("NFC", printed)
    assert "-c (cos²(ψ) + cos²(a + ψ)) ẋ" in text
    assert "- c (cos(ψ) sin(ψ) + cos(a + ψ) sin(a + ψ)) ẏ" in text


def chain(count: int, *, apart: bool = False) -> System:
    """Return bars of 1 m that turn about z, y and z again, each at the end of the one before."""
    frame, bodies = move(), []
    for k in range(count):
        turn = (rot_z if k % 2 else rot_y)(angle(f"q{k}"))
        frame = move(0, 0, 0 if apart else 1) @ turn if apart or not k else frame @ move(1) @ turn
        inertia = (0.1, 0.2, 0.25)
        bodies.append(Body(f"bar {k}", frame @ move(0.5), mass=1.0, inertia=inertia))
    return System(f"chain{count}", bodies=bodies, gravity=toward("-z"))


def test_what_nobody_could_read_is_refused_at_once() -> None:
    """The kinetic energy of a chain of 20 joints has seven million symbols."""
    begin = time.process_time()
    for machine in (chain(20), chain(62)):
        with pytest.raises(InputError, match=r"of \d\d coordinates, are too long to be read\. Its"):
            machine.equations()
        assert machine._repr_latex_() is None
    assert time.process_time() - begin < 20.0  # [s]; the first joint's equation took minutes


def test_many_coordinates_may_have_short_equations() -> None:
    """Length is what counts, not the number of joints: these pendulums do not feel each other."""
    equations = chain(20, apart=True).equations()
    assert len(equations.balance) == 20


def test_a_notebook_shows_short_equations_and_names_other_machines() -> None:
    shown = kinolab.systems.get("crane")._repr_latex_()
    assert shown is not None
    assert shown.startswith("$$")
    assert kinolab.systems.get("panda")._repr_latex_() is None
    assert kinolab.systems.get("biped")._repr_latex_() is None  # its modes have some each
