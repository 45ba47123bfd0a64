"""Plans that are proved for all machines within some bounds: they keep back what feedback needs.

A plan is made, and its tube says how much of the inputs' limits feedback takes, and how far bodies
come from their places. The motion is then shortened again with so much kept back from limits and
obstacles, until the proof succeeds. What a plan needs is read off its tube, or, where that
ends early, off the tube's linear part without limits.

Source: Majumdar, Tedrake, Funnel libraries for real-time robust feedback motion planning, IJRR
36(8), 2017 (plans made for their funnels); Chisci, Rossiter, Zappa, Systems with persistent
disturbances: predictive control with restricted constraints, Automatica 37(7), 2001 (limits less
what feedback needs).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np

from kinolab.concurrency.stages import doing
from kinolab.errors import EndpointError, InputError
from kinolab.problem import PlanningTask
from kinolab.solve.robustness.reserves import Reserves, input_needs, needed
from kinolab.trajectory import Trajectory
from kinolab.verification.tube.claim import Claim, claimed
from kinolab.verification.tube.proof import Prover, TubeProof, require_provable
from kinolab.verification.tube.uncertainty import Uncertainty

# By which what is kept back is larger than what the linear part of a tube needs, in each round:
# the rest of the tube needs some, too, and the next plan may need more than this one.
FIRST_FACTOR, GROWTH = 1.1, 1.25


class Made(Protocol):
    """What comes of a plan, as far as it matters here."""

    @property
    def status(self) -> str:
        """``solved``, if there is a plan."""

    @property
    def trajectory(self) -> Trajectory | None:
        """Its motion."""


T = TypeVar("T", bound=Made)


def best_tuned(prover: Prover, uncertainty: Uncertainty) -> tuple[Prover, TubeProof]:
    """Return a prover with the gains that prove most, and its proof.

    Stiffer gains keep deviations smaller, and need more of the inputs: those are tried first that
    are stiffest among those that need hardly more than the softest ones.
    """
    model = prover.problem.whole or prover.problem.model
    half = 0.5 * np.ptp(model.control_bounds, axis=1)
    # large deviations, as of the ``Tracker``: softest first
    made = [prover.retuned(large) for large in (0.2, 0.1, 0.05, 0.025)]
    needs = [float((input_needs(one.expected(uncertainty)) / half).max()) for one in made]
    # times the inputs that the softest gains need may be taken by stiffer ones
    cheap = [k for k, need in enumerate(needs) if need <= 1.25 * min(needs)]
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
    solve: Callable[[PlanningTask, Trajectory | None], T],
    guess: Trajectory | None,
) -> tuple[T, Claim | None]:
    """Return a plan that is proved as its scenario asks, or under less, and what is proved.

    Args:
        problem: With [robust], which says what may differ from a plan's assumptions.
        solve: Plans, from a motion that is nearly one where there is such.
        guess: The first of them.

    Raises:
        InputError: If there is no proof for the machine, or the uncertainty makes no sense for it.
    """
    asked = Uncertainty.of(problem)
    assert asked is not None
    require_provable(problem)
    last: tuple[T, Prover] | None = None
    reserves, factor = Reserves(), FIRST_FACTOR
    for _ in range(5):  # rounds of plans, each with more kept back; what needs more is not proved
        made = _planned(problem, reserves, solve, guess)
        if made is None or made.status != "solved" or made.trajectory is None:
            break
        guess = made.trajectory
        doing("proving the plan for all machines within the bounds")
        prover, proof = best_tuned(Prover(problem, guess), asked)
        last = made, prover
        if proof.proved:
            return made, Claim(problem, asked, proof, 1.0, proof)
        tube = proof.tube if proof.tube.complete else prover.expected(asked)
        wanted = needed(prover, tube, asked, factor)
        if not proof.tube.complete or proof.spare > 0.0:
            wanted = replace(wanted, distance=0.0)  # nobody knows yet, or nothing is touched
        reserves, factor = reserves.joined(wanted), GROWTH * factor
        doing(f"planning again, with more kept back: {_why(proof)}")
    if last is None:
        assert made is not None  # the first plan keeps nothing back
        return made, None
    return last[0], claimed(last[1], asked)


def _planned(
    problem: PlanningTask,
    reserves: Reserves,
    solve: Callable[[PlanningTask, Trajectory | None], T],
    guess: Trajectory | None,
) -> T | None:
    """Return a plan that keeps something back; None where nothing is left of the limits then."""
    try:
        return solve(reserves.kept(problem), guess)
    except (EndpointError, InputError):
        if reserves == Reserves():
            raise
        return None


def _why(proof: TubeProof) -> str:
    return "" if proof.first is None else f"t = {proof.first.time:.3g} s, {proof.first.what}"
