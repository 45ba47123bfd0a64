"""Stability limit of explicit integrators: is the step short enough for the fastest mode?"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import IntegrationSection

RANDOM_STATES = 100  # of each kind
FEW_STATES = 10  # of a machine by itself
UNLIMITED_INPUT = 1e3  # sampling limit of an unbounded input, in its unit


@dataclass(frozen=True)
class Stiffness:
    """An integration step beyond its method's stability limit.

    Attributes:
        method: Integration method.
        step: Length of one step of the method, in [s].
        limit: Upper bound of a stable step, in [s].
        rate: Of the fastest mode, in [1/s]: the spectral radius of df/dx.
        substeps: Number of method steps per propagation step.
    """

    method: str
    step: float
    limit: float
    rate: float
    substeps: int = 1

    @property
    def sentence(self) -> str:
        """The mistake and its remedy, in words."""
        steps = "steps" if self.substeps == 1 else "substeps"
        enough = math.ceil(self.substeps * self.step / self.limit)
        return (
            f"Something in this machine changes within {1.0 / self.rate:.2g} s, and {self.method} "
            f"turns that into growth at {steps} of {self.step:.3g} s: it needs {steps} below "
            f'{self.limit:.2g} s ([integration] substeps = {enough}), or method = "rosenbrock".'
        )


def stiffness(problem: PlanningTask, visited: Array | None = None) -> Stiffness | None:
    """Return why a problem's steps are unstable; None where they are stable or implicit.

    Examines the start, goal samples, samples within the limits, moving and at rest, and states
    that a search visited.

    Args:
        problem: Provides the machine and the integration settings.
        visited: States of the search, shape (N, nx).
    """
    generator = np.random.default_rng(0)
    kinds = [problem.start[None], *_sampled(problem, generator)]
    if visited is not None and len(visited):
        kinds.append(visited[:: -(-len(visited) // RANDOM_STATES)])
    settings = problem.scenario.integration
    return step_too_long(settings, max(decay_rate(problem.model, x, generator) for x in kinds))


def step_too_long(settings: IntegrationSection, rate: float) -> Stiffness | None:
    """Return why steps are unstable for a mode of a given rate in [1/s]; None if they are not."""
    step = settings.step / settings.substeps
    stable = METHODS[settings.method].stability
    if rate * step <= stable:
        return None
    return Stiffness(settings.method, step, stable / rate, rate, settings.substeps)


def fastest_rate(model: Model) -> float:
    """Return the rate of a machine's fastest stable mode, at rest and in motion, in [1/s]."""
    generator, moving = np.random.default_rng(0), random_states(model)
    still = moving.copy()
    still[:, model.speeds] = 0.0  # where dry friction is stiffest
    kinds = (model.rest()[None], moving, still)
    return max(decay_rate(model, x, generator) for x in kinds)


def random_states(model: Model) -> Array:
    """Return states within limits and on the constraints, shape (FEW_STATES, nx)."""
    generator = np.random.default_rng(0)
    lower, upper = model.state_bounds.T
    middle = model.rest()
    lower = np.where(np.isfinite(lower), lower, middle - model.state_scales)
    upper = np.where(np.isfinite(upper), upper, middle + model.state_scales)
    states = middle + 0.5 * (generator.uniform(lower, upper, (FEW_STATES, model.nx)) - middle)
    for _ in range(20):
        states = model.project(states)
    return states


def decay_rate(model: Model, x: Array, generator: np.random.Generator) -> float:
    """Return the 90th percentile over states of the fastest stable mode's rate, in [1/s].

    The machine's feedback is left out: its inputs are constant during a step.

    Args:
        x: States, shape (N, nx).
        generator: Draws the inputs at which, besides zero input, modes are computed.
    """
    lower, upper = np.clip(model.control_bounds, -UNLIMITED_INPUT, UNLIMITED_INPUT).T
    drawn = generator.uniform(lower, upper, (len(x), model.nu))
    idle = np.broadcast_to(np.clip(0.0, lower, upper), drawn.shape)
    rates = np.zeros(len(x))
    for u in (idle, drawn):
        rates = np.maximum(rates, [_fading_at(model, *one) for one in zip(x, u, strict=True)])
    return float(np.quantile(rates, 0.9, method="lower"))  # stiffness at isolated states is ignored


def _fading_at(model: Model, x: Array, u: Array) -> float:
    """Return the fastest stable mode's rate at one (x, u); 0 where the equations are singular."""
    try:
        slope = model.plant.jacobian(x, model.plant_inputs(x, u))[0]
    except KinolabError:
        return 0.0
    if not np.isfinite(slope).all():
        return 0.0
    found = np.linalg.eigvals(slope)
    # Re(lambda) / |lambda| above which a mode counts as unstable
    return float(np.abs(found[found.real <= 0.5 * np.abs(found)]).max(initial=0.0))


def _sampled(problem: PlanningTask, generator: np.random.Generator) -> list[Array]:
    """Return goal samples, samples within the limits, and the latter at rest."""
    goals = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    moving = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    aimed, (lower, upper) = list(problem.goal.indices), problem.sampling_bounds.T
    moving[:, aimed] = generator.uniform(lower, upper, moving.shape)[:, aimed]
    still = moving.copy()
    still[:, problem.model.speeds] = 0.0
    return [problem.model.project(x) for x in (goals, moving, still)]
