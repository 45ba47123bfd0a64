"""What was proved of a plan, in sentences and as data that can be proved again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinolab.concurrency.stages import doing
from kinolab.numerics.arrays import finite_or_none
from kinolab.problem import PlanningTask
from kinolab.verification.checks.check import Check
from kinolab.verification.tube.proof import Prover, TubeProof
from kinolab.verification.tube.uncertainty import Uncertainty

AGREE = 1e-6  # relative: what another processor's rounding may change in the numbers of a proof
NUMBERS = ("proved_until", "excess", "spare")


@dataclass(frozen=True, eq=False)
class Claim:
    """The answer to a question: is a plan proved under an uncertainty, and if not, how far?

    Attributes:
        problem: The problem of the plan.
        asked: What was asked for.
        answer: What is proved under that.
        share: The largest share of it that is proved; 1 if all of it is.
        best: What is proved under that share; None where it is nothing.
    """

    problem: PlanningTask
    asked: Uncertainty
    answer: TubeProof
    share: float
    best: TubeProof | None

    @property
    def proved(self) -> bool:
        """Whether all that was asked for is proved."""
        return self.answer.proved

    @property
    def proof(self) -> TubeProof:
        """The proof that counts: of the largest share, or the attempt where there is none."""
        return self.best or self.answer

    def __str__(self) -> str:
        """Say what is proved, and what could happen beyond."""
        return "\n".join(self.lines())

    def lines(self) -> Iterator[str]:
        """Yield the verdict, then facts, a line each."""
        if self.proved:
            yield f"proved: every machine with {self.asked} carries the plan out"
        else:
            yield f"not proved for {self.asked}"
            first = self.answer.first
            if first is not None:
                yield f"  from t = {first.time:.4g} s on: {first.what}"
            yield self._share_line()
        if self.proof.proved:
            yield from self._facts()

    def _share_line(self) -> str:
        if self.best is None:
            until = self.answer.proved_until
            return f"  nothing is proved to the end; under what was asked, until t = {until:.4g} s"
        return f"  proved up to {self.share:.3g} of that: {self.best.uncertainty}"

    def _facts(self) -> Iterator[str]:
        proof, problem = self.proof, self.problem
        if math.isfinite(proof.spare):
            yield f"  touches nothing: at least {1000 * proof.spare:.3g} mm of clearance are left"
        yield f"  ends in the goal: at most {proof.excess:.3g} tolerances off"
        sizes = widest(proof)
        farthest = np.argsort(-sizes / problem.scales, kind="stable")[:4]
        names = problem.model.state_names
        told = ", ".join(f"{names[i]} {sizes[i]:.3g}" for i in farthest)
        yield f"  farthest from the plan, relative to their scales: {told}"
        cut = sum(held.cut.any() for held in proof.tube.inputs)
        if cut:
            yield f"  inputs may reach their limits in {cut} of {proof.tube.steps} steps"


def widest(proof: TubeProof) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return how far each entry of the state is from the plan at most at the rows, shape (nx,)."""
    bounds = proof.tube.bounds
    return np.asarray(np.maximum(np.abs(bounds.low), np.abs(bounds.high)).max(axis=0))


def claimed(prover: Prover, asked: Uncertainty) -> Claim:
    """Answer whether a plan is proved under an uncertainty, and if not, under which share of it.

    Args:
        asked: What may differ from the plan's assumptions.

    Raises:
        InputError: If it makes no sense for the machine.
    """
    doing("proving what was asked for")
    answer = prover.prove(asked)
    if answer.proved:
        return Claim(prover.problem, asked, answer, 1.0, answer)
    share, best = prover.largest(asked)
    return Claim(prover.problem, asked, answer, share, best)


def proof_to_json(problem: PlanningTask, proof: TubeProof) -> dict[str, Any]:
    """Return what is proved as plain data."""
    hazard, bounds = proof.first, proof.tube.bounds
    names = problem.model.state_names
    return {
        "uncertainty": proof.uncertainty.to_json(),
        "large": proof.large,
        "proved": proof.proved,
        **{name: finite_or_none(getattr(proof, name)) for name in NUMBERS},
        "first_hazard": None if hazard is None else {"time": hazard.time, "what": hazard.what},
        "t": proof.tube.nominal.t[: proof.tube.steps + 1].tolist(),
        "low": dict(zip(names, bounds.low.T.tolist(), strict=True)),
        "high": dict(zip(names, bounds.high.T.tolist(), strict=True)),
    }


def proved_again(problem: PlanningTask, trajectory: Any, stored: Mapping[str, Any]) -> Check:
    """Prove a claim again, and compare every number of it.

    Args:
        stored: What ``proof_to_json`` returned.
    """
    try:
        uncertainty = Uncertainty.from_json(stored["uncertainty"])
        prover = Prover(problem, trajectory, large=float(stored["large"]))
        found = proof_to_json(problem, prover.prove(uncertainty))
        off = sorted(key for key in found if not _same(stored.get(key), found[key]))
    except (KeyError, TypeError, ValueError) as error:
        return Check("tube", math.inf, 0.0, False, f"tube.json cannot be read ({error})")
    off += sorted(set(stored) - set(found))
    detail = f"proved again, it differs in {', '.join(off)}" if off else ""
    return Check("tube", float(len(off)), 0.0, not off, detail)


def _same(a: Any, b: Any) -> bool:
    """Say whether data agree: words exactly, numbers to ``AGREE`` of the largest beside them."""
    if isinstance(b, Mapping):
        return isinstance(a, Mapping) and a.keys() == b.keys() and all(_same(a[k], b[k]) for k in b)
    if isinstance(b, list):
        return _close(a, b)
    if isinstance(b, float) and not isinstance(a, bool) and isinstance(a, int | float):
        return _close([a], [b])
    return type(a) is type(b) and bool(a == b)


def _close(a: Any, b: list[float]) -> bool:
    """Say whether lists of numbers agree."""
    if not isinstance(a, list) or len(a) != len(b):
        return False
    found, wanted = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return bool((np.abs(found - wanted) <= AGREE * np.abs(wanted).max(initial=0.0)).all())
