"""Plans that are proved for all machines within some bounds: they keep back what feedback needs.

A plan is made, and its tube says how much of the inputs' limits feedback takes, and how far bodies
come from their places. The motion is then shortened again with so much kept back from limits and
obstacles, until the proof succeeds. What a plan needs is read off the linear part of its tube,
without limits: that is known also where the tube itself is not.

Source: Majumdar, Tedrake, Funnel libraries for real-time robust feedback motion planning, IJRR
36(8), 2017 (plans made for their funnels); Chisci, Rossiter, Zappa, Systems with persistent
disturbances: predictive control with restricted constraints, Automatica 37(7), 2001 (limits less
what feedback needs).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from kinolab import loading
from kinolab.errors import EndpointError, InputError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.solve.plan import PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from kinolab.verification.tube.claim import Claim, claimed
from kinolab.verification.tube.proof import Prover, TubeProof, require_provable
from kinolab.verification.tube.reachability import Tube
from kinolab.verification.tube.tube_poses import TubePoses
from kinolab.verification.tube.uncertainty import Uncertainty

ROUNDS = 5  # of plans, each with more kept back; what needs more is not proved
# By which what is kept back is larger than what the linear part of a tube needs, in each round:
# the rest of the tube needs some, too, and the next plan may need more than this one.
FIRST_FACTOR, GROWTH = 1.1, 1.25
MOST = 0.6  # of half an input's range that is kept back: plans with less are hardly motions
FAR = 1e6  # [m]: nothing is as far off as that
GAINS = (0.2, 0.1, 0.05, 0.025)  # large deviations, as of the ``Tracker``: softest first
STIFFER = 1.25  # times the inputs that the softest gains need may be taken by stiffer ones

Solve = Callable[[PlanningTask, Trajectory | None], PlanResult]


@dataclass(frozen=True)
class Reserves:
    """What a plan keeps back.

    Attributes:
        inputs: Of each input's limits, by name.
        states: Of each coordinate's limits, by name.
        distance: Of limits of the workspace and from obstacles, in [m].
    """

    inputs: dict[str, float] = field(default_factory=dict)
    states: dict[str, float] = field(default_factory=dict)
    distance: float = 0.0

    def joined(self, other: Reserves) -> Reserves:
        """Return the larger of each."""

        def larger(a: dict[str, float], b: dict[str, float]) -> dict[str, float]:
            return {name: max(a.get(name, 0.0), b.get(name, 0.0)) for name in a | b}

        distance = max(self.distance, other.distance)
        inputs, states = larger(self.inputs, other.inputs), larger(self.states, other.states)
        return Reserves(inputs, states, distance)

    def kept(self, problem: PlanningTask) -> PlanningTask:
        """Return the problem in which so much is kept back.

        Raises:
            InputError: If nothing is left.
        """
        scenario, whole = problem.scenario, problem.whole or problem.model
        values: dict[str, object] = {}
        limits = dict(zip(whole.control_names, whole.control_bounds.tolist(), strict=True))
        limits |= dict(zip(whole.state_names, whole.state_bounds.tolist(), strict=True))
        for name, reserve in (self.inputs | self.states).items():
            low, high = limits[name]
            own = scenario.bounds.get(name, (low, high))
            values[f"bounds.{name}"] = [max(own[0], low + reserve), min(own[1], high - reserve)]
        if self.distance:
            values["world.clearance"] = scenario.world.clearance + self.distance
        for axis, (low, high) in scenario.world.bounds.items():
            values[f"world.bounds.{axis}"] = [low + self.distance, high - self.distance]
        return loading.built(*loading.read_changed(scenario, values)) if values else problem


def needed(prover: Prover, expected: Tube, uncertainty: Uncertainty, factor: float) -> Reserves:
    """Return what a plan needs, a factor larger than the linear part of its tube says.

    Args:
        prover: Of the plan.
        expected: The linear part of its tube.
        uncertainty: Under which.
        factor: At least 1.
    """
    problem = prover.problem
    model = problem.whole or problem.model
    half = 0.5 * np.ptp(model.control_bounds, axis=1)
    inputs = np.minimum(factor * _input_needs(expected), MOST * half)
    poses = TubePoses.of(problem, prover.about, expected, uncertainty.radii(problem))
    off = factor * poses.displacements(problem)
    bounds = expected.bounds
    states = factor * np.maximum(-bounds.low, bounds.high).max(axis=0)
    limited = np.isfinite(model.state_bounds).all(axis=1) & ~problem.circular
    limited[model.speeds] = False
    at = np.minimum(_clearances(prover), FAR)
    most = off.max(axis=0)
    short = np.vstack([off, most]) - at
    wanted = np.where(short > 0.0, at.min(axis=0) + short, 0.0)  # of the whole machine
    return Reserves(
        dict(zip(model.control_names, inputs.tolist(), strict=True)),
        {model.state_names[i]: float(states[i]) for i in np.flatnonzero(limited)},
        float(wanted.max(initial=0.0)),
    )


def _input_needs(tube: Tube) -> Array:
    """Return how far inputs are from the planned ones at most, shape (nu,)."""
    return np.asarray(np.max([np.maximum(-one.low, one.high) for one in tube.inputs], axis=0))


def _clearances(prover: Prover) -> Array:
    """Return the clearances of the plan in each step, at its ends, as ``ContactSearch`` does."""
    at = prover.contacts.clearances(prover.about.nominal.x)
    return np.asarray(np.minimum(at[:, 1:], at[:, :-1]))


def best_tuned(prover: Prover, uncertainty: Uncertainty) -> tuple[Prover, TubeProof]:
    """Return a prover with the gains that prove most, and its proof.

    Stiffer gains keep deviations smaller, and need more of the inputs: those are tried first that
    are stiffest among those that need hardly more than the softest ones.
    """
    model = prover.problem.whole or prover.problem.model
    half = 0.5 * np.ptp(model.control_bounds, axis=1)
    made = [prover.retuned(large) for large in GAINS]
    needs = [float((_input_needs(one.expected(uncertainty)) / half).max()) for one in made]
    cheap = [k for k, need in enumerate(needs) if need <= STIFFER * min(needs)]
    order = [cheap[-1], *(k for k in range(len(made)) if k != cheap[-1])]
    best: tuple[Prover, TubeProof] | None = None
    for k in order:
        proof = made[k].prove(uncertainty)
        if best is None or (proof.proved, proof.proved_until) > (
            best[1].proved,
            best[1].proved_until,
        ):
            best = made[k], proof
        if proof.proved:
            break
    assert best is not None
    return best


def solved_robustly(
    problem: PlanningTask,
    asked: Uncertainty,
    solve: Solve,
    guess: Trajectory | None,
    told: Callable[[str], None] = lambda _: None,
) -> PlanResult:
    """Return a plan that is proved under an uncertainty, or one that is proved under less.

    Args:
        problem: The problem.
        asked: What may differ from its assumptions.
        solve: Plans, from a motion that is nearly one where there is such.
        guess: The first of them.
        told: Called now and then with what is being done.

    Raises:
        InputError: If there is no proof for the machine, or the uncertainty makes no sense for it.
    """
    require_provable(problem)
    asked.require(problem)
    last: tuple[PlanResult, Prover] | None = None
    reserves, factor = Reserves(), FIRST_FACTOR
    for _ in range(ROUNDS):
        made = _planned(problem, reserves, solve, guess)
        if made is None or made.status != "solved" or made.trajectory is None:
            break
        guess = made.trajectory
        told("proving the plan for all machines within the bounds")
        prover, proof = best_tuned(Prover(problem, guess), asked)
        last = made, prover
        if proof.proved:
            return _with_claim(problem, made, Claim(problem, asked, proof, 1.0, proof))
        wanted = needed(prover, prover.expected(asked), asked, factor)
        if not proof.tube.complete or proof.spare > 0.0:
            wanted = replace(wanted, distance=0.0)  # nobody knows yet, or nothing is touched
        reserves, factor = reserves.joined(wanted), GROWTH * factor
        told(f"planning again, with more kept back: {_why(proof)}")
    if last is None:
        assert made is not None  # the first plan keeps nothing back
        return made
    return _with_claim(problem, last[0], claimed(last[1], asked, told))


def _planned(
    problem: PlanningTask, reserves: Reserves, solve: Solve, guess: Trajectory | None
) -> PlanResult | None:
    """Return a plan that keeps something back; None where nothing is left of the limits then."""
    try:
        return solve(reserves.kept(problem), guess)
    except (EndpointError, InputError):
        if reserves == Reserves():
            raise
        return None


def _why(proof: TubeProof) -> str:
    return "" if proof.first is None else f"t = {proof.first.time:.3g} s, {proof.first.what}"


def _with_claim(problem: PlanningTask, made: PlanResult, claim: Claim) -> PlanResult:
    """Return a plan with what is proved of it, certified as one of the problem itself."""
    assert made.trajectory is not None
    return replace(made, certificate=verify(problem, made.trajectory), claim=claim)
