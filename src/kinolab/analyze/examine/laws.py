"""Laws of mechanics checked on a machine, against independent computations.

Each law is checked on the compiled model against code that it does not share: finite differences,
an energy balance along a DOP853 run, or SymPy's own derivation.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab.analyze.examine.law_check import LawCheck
from kinolab.dynamics import Model, System
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.derivation.singularity import singularity_of
from kinolab.dynamics.facts.mode_derivations import in_mode
from kinolab.errors import KinolabError, NoDynamicsError
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.stability import fastest_rate, random_states, step_too_long


def laws(system: System, integration: IntegrationSection | None = None) -> Iterator[LawCheck]:
    """Yield the results of checking the laws of mechanics on a machine.

    Args:
        integration: The integration settings for planning; not checked if left out.

    Raises:
        InputError: If the machine cannot be derived.
    """
    model = system.model()
    states = random_states(model)
    inputs = model.control_bounds.mean(axis=1) + 0.3 * np.ptp(model.control_bounds, axis=1)
    inputs = inputs if model.nu else np.zeros(0)
    yield _jacobian(model, states, inputs)
    if system.constraints:
        yield _constraints(model, states, inputs)
        yield _velocities(system)
    try:
        yield from _mass_matrix(model, states)
        yield _energy(model, states[0], inputs)
    except NoDynamicsError:
        pass  # it has no masses, and no laws for them
    if integration is not None:
        yield _steps(model, integration)


def _jacobian(model: Model, states: NDArray[np.float64], u: NDArray[np.float64]) -> LawCheck:
    worst = 0.0
    for x in states:
        exact, _ = model.jacobian(x, u)
        steps = 1e-6 * model.state_scales
        columns = [
            (model.f(x + h * e, u) - model.f(x - h * e, u)) / (2 * h)
            for h, e in zip(steps, np.eye(model.nx), strict=True)
        ]
        size = max(1.0, float(np.abs(exact).max()))
        worst = max(worst, float(np.abs(exact - np.array(columns).T).max()) / size)
    return LawCheck(
        "derivatives of the equations of motion equal finite differences",
        worst,
        1e-6,
        ""
        if worst <= 1e-6
        else "the equations have a kink, such as that of a sign or an absolute value at zero, "
        "over which planning by derivatives stumbles",
        own=True,
    )


def _constraints(model: Model, states: NDArray[np.float64], u: NDArray[np.float64]) -> LawCheck:
    count = len(model.system.constraints)
    residual = np.abs(model.constraint_residual(states, u)[:, :count]).max()
    repeated = ", ".join(model.redundant)
    note = f"{repeated} follows from the other constraints" if repeated else ""
    return LawCheck("velocities obey the constraints", float(residual), 1e-9, note, own=True)


def modes_alone(model: Model) -> Iterator[LawCheck]:
    """Compare each mode with the machine that has no other: by multipliers, and without."""
    for number in range(len(model.machine.modes)):
        yield _mode(model, random_states(model), number)


def _mode(model: Model, states: NDArray[np.float64], number: int) -> LawCheck:
    name = model.machine.modes[number]
    own = System.of(in_mode(model.system, name)).model()
    law = f"in mode {name!r} it moves as the machine that has no other mode"
    x = states.copy()
    x[:, -1] = number
    for _ in range(20):
        x = model.project(x)
    u = model.null_control()
    entries = [model.state_names.index(entry) for entry in own.state_names]
    held = u[[model.control_names.index(entry) for entry in own.control_names]]
    try:
        whole, alone = model.f(x, u)[:, entries], own.f(x[:, entries], held)
    except KinolabError as error:
        return LawCheck(law, 0.0, 0.0, f"not compared: {error}")
    gap = float(np.abs(whole - alone).max() / max(1.0, float(np.abs(alone).max())))
    note = "" if gap <= 1e-8 else "masses that differ by many orders of magnitude cost digits"
    return LawCheck(law, gap, 1e-8, note, own=True)


def _velocities(system: System) -> LawCheck:
    """Say whether the velocities that are states determine all others everywhere."""
    law, found = "independent velocities determine the others", singularity_of(system)
    return LawCheck(law, 0.0, 0.0, "" if found is None else found.sentence)


def _mass_matrix(model: Model, states: NDArray[np.float64]) -> Iterator[LawCheck]:
    asymmetry, smallest = 0.0, np.inf
    for x in states:
        M = model.mass_matrix(x)
        asymmetry = max(asymmetry, float(np.abs(M - M.T).max() / np.abs(M).max()))
        own = np.sqrt(np.maximum(np.diag(M), 1e-300))
        smallest = min(smallest, float(np.linalg.eigvalsh(M / np.outer(own, own))[0]))
    yield LawCheck("the mass matrix is symmetric", asymmetry, 1e-12, own=True)
    law, held = "whatever moves has mass or inertia", model.system.constraints and smallest <= 0
    note = "where a coordinate moves nothing with mass, a constraint must hold it" if held else ""
    yield LawCheck(law, 0.0 if held else max(-smallest, 0.0), 1e-12, note)


def _energy(model: Model, x: NDArray[np.float64], u: NDArray[np.float64]) -> LawCheck:
    """Balance d/dt (T + V) against the power of inputs and friction along a run."""

    def change(_: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.append(model.f(y[:-1], u), model.power(y[:-1], u))

    def within(_: float, y: NDArray[np.float64]) -> float:
        lower, upper = model.state_bounds.T
        return float(min((upper - y[:-1]).min(), (y[:-1] - lower).min()))

    within.terminal = True  # type: ignore[attr-defined]  # laws need hold within the limits only
    law = "energy changes by the work of inputs and friction"
    # Where velocities are singular somewhere, a run may end, though the laws hold.
    # 8 times that a run into a singularity is halved
    shorter = 8 if singularity_of(model.system) else 0
    for duration in 2.0 * 0.5 ** np.arange(shorter + 1):  # [s] of the energy-balance run
        try:
            run = solve_ivp(
                change,
                (0.0, duration),
                np.append(x, 0.0),
                method="DOP853",
                events=within,
                rtol=1e-9,
                atol=1e-11,
            )
            break
        except KinolabError as error:
            wrong = str(error)
    else:
        return LawCheck(law, np.inf, 1e-7, f"the run ended early: {wrong}")
    energies = [sum(model.energy(run.y[:-1, k], u)) for k in (0, -1)]
    work = float(run.y[-1, -1])
    size = max(1.0, *map(abs, energies), abs(work))
    gap = abs(energies[1] - energies[0] - work) / size
    note = (
        f"in {run.t[-1]:.3g} s the energy changes by {energies[1] - energies[0]:+.3g} J; "
        f"the work is {work:+.3g} J"
    )
    return LawCheck(law, gap, 1e-7, note)


def _steps(model: Model, settings: IntegrationSection) -> LawCheck:
    """Compare the fastest decay rate, at rest and in motion, with the integrator's stability."""
    rate = fastest_rate(model)
    step, wrong = settings.step / settings.substeps, step_too_long(settings, rate)
    law = f"{settings.method} is stable at steps of {step:g} s"
    if wrong is not None:
        return LawCheck(law, rate * step, METHODS[settings.method].stability, wrong.sentence)
    note = f"the fastest decay rate is {rate:.3g} /s"
    if is_kinematic(model.system) and not model.system.states:
        note = "it is kinematic, and nothing in it decays by itself"
    return LawCheck(law, rate * step, METHODS[settings.method].stability, note)
