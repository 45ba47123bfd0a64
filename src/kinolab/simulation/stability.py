"""Are steps short enough for what fades or swings fastest? Longer ones make it grow instead.

Source: Hairer, Wanner, Solving ODEs II, 2nd ed., section IV.2 (stability functions).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import IntegrationSection

# |h lambda| up to which |R(h lambda)| <= 1 for lambda < 0
STABILITY_BOUNDS = {"rk4": 2.785, "euler": 2.0}
RANDOM_STATES = 100  # of each kind
QUANTILE = 0.9  # share of them: what is stiff at few places only is not counted
GROWTH_RATIO = 0.5  # Re(lambda) / |lambda| above which something truly grows
UNLIMITED_INPUT = 1e3  # of an input without a limit, in its unit


@dataclass(frozen=True)
class Stiffness:
    """Steps that are too long for a machine.

    Attributes:
        method: Of integration.
        step: How long each step of the method is, in [s].
        limit: Steps must be shorter, in [s].
        rate: At which something fades or swings, in [1/s]: the spectral radius of df/dx.
        substeps: Of which a step of the problem is made.
    """

    method: str
    step: float
    limit: float
    rate: float
    substeps: int = 1

    @property
    def sentence(self) -> str:
        """What is wrong, and what would work."""
        steps = "steps" if self.substeps == 1 else "substeps"
        return (
            f"Something in this machine changes within {1.0 / self.rate:.2g} s, and {self.method} "
            f"turns that into growth at {steps} of {self.step:.3g} s: it needs {steps} below "
            f'{self.limit:.2g} s, or [integration] method = "rosenbrock".'
        )


def stiffness(problem: PlanningTask, visited: Array | None = None) -> Stiffness | None:
    """Return what makes a problem's steps unstable; None where they are stable, or implicit.

    Looks at the start, at states of the goal, at others within the limits, moving and at rest, and
    at those that a search came to.

    Args:
        problem: With the machine and its steps.
        visited: States, shape (N, nx).
    """
    generator = np.random.default_rng(0)
    kinds = [problem.start[None], *_sampled(problem, generator)]
    if visited is not None and len(visited):
        kinds.append(visited[:: -(-len(visited) // RANDOM_STATES)])
    settings = problem.scenario.integration
    return step_too_long(settings, max(decay_rate(problem.model, x, generator) for x in kinds))


def step_too_long(settings: IntegrationSection, rate: float) -> Stiffness | None:
    """Return what makes steps unstable for something that fades at a rate in [1/s], if it does."""
    step = settings.step / settings.substeps
    stable = STABILITY_BOUNDS.get(settings.method)
    if stable is None or rate * step <= stable:
        return None
    return Stiffness(settings.method, step, stable / rate, rate, settings.substeps)


def decay_rate(model: Model, x: Array, generator: np.random.Generator) -> float:
    """Return the rate of the fastest thing that does not grow at nine of ten states, in [1/s].

    A machine's own feedback does not count: its inputs are held during a step.

    Args:
        model: The machine.
        x: States, shape (N, nx).
        generator: Of inputs, which may change what fades; that none act is looked at besides.
    """
    lower, upper = np.clip(model.control_bounds, -UNLIMITED_INPUT, UNLIMITED_INPUT).T
    drawn = generator.uniform(lower, upper, (len(x), model.nu))
    idle = np.broadcast_to(np.clip(0.0, lower, upper), drawn.shape)
    rates = np.zeros(len(x))
    for u in (idle, drawn):
        rates = np.maximum(rates, [_fading_at(model, *one) for one in zip(x, u, strict=True)])
    return float(np.quantile(rates, QUANTILE, method="lower"))


def _fading_at(model: Model, x: Array, u: Array) -> float:
    """Return the rate at one state under inputs; 0 where the equations have no solution."""
    try:
        slope = model.plant.jacobian(x, model.plant_inputs(x, u))[0]
    except KinolabError:
        return 0.0
    if not np.isfinite(slope).all():
        return 0.0
    found = np.linalg.eigvals(slope)
    return float(np.abs(found[found.real <= GROWTH_RATIO * np.abs(found)]).max(initial=0.0))


def _sampled(problem: PlanningTask, generator: np.random.Generator) -> list[Array]:
    """Return states of the goal, states within the limits, and the latter at rest."""
    goals = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    moving = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    aimed, (lower, upper) = list(problem.goal.indices), problem.sampling_bounds.T
    moving[:, aimed] = generator.uniform(lower, upper, moving.shape)[:, aimed]
    still = moving.copy()
    still[:, problem.model.speeds] = 0.0
    return [problem.model.project(x) for x in (goals, moving, still)]
