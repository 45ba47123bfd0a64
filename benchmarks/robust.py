"""What is proved of the gallery's plans on uncertain machines, and whether proofs hold.

    python benchmarks/robust.py RUN ... [--percent 5] [--runs 40]

RUN is the folder of a finished run. Of each: the percentage that is proved of all parameters that
are uncertain by default, what could happen first beyond it, and rough CPU time. Then machines at
random corners and inside of the proved intervals are followed by SciPy's DOP853 to 1e-10, under the
same feedback: none may be outside the tube. How wide the tube is, at its widest, beside the hull of
these motions is printed for the median and the worst entry of the state. Returns 1 where a motion
is outside.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from kinolab.errors import InputError
from kinolab.runs import read_run
from kinolab.verification.tube.claim import Claim, claimed
from kinolab.verification.tube.proof import Prover, TubeProof
from kinolab.verification.tube.uncertainty import Uncertainty, kept_by_default, varied_by_default

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.closed_loops import executed, outside  # the oracle of the tests

ROUNDING = 1e-9  # of a state's scale: what SciPy's motions may be off by


def main(arguments: list[str]) -> int:
    """Prove each run, and try the proofs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs_", metavar="RUN", type=Path, nargs="+")
    parser.add_argument("--percent", type=float, default=5.0)
    parser.add_argument("--runs", type=int, default=40)
    asked = parser.parse_args(arguments)
    wrong = 0
    for folder in asked.runs_:
        try:
            wrong += one(folder, asked.percent, asked.runs)
        except InputError as error:
            print(f"{folder.name}: {error}", flush=True)
    return int(wrong > 0)


def one(folder: Path, percent: float, runs: int) -> int:
    """Print what is proved of one run, and return how many motions are outside the tube."""
    begin, run = time.process_time(), read_run(folder)
    prover = Prover(run.problem, run.trajectory)
    names = varied_by_default(run.problem, kept_by_default(run.problem.system))
    claim = claimed(prover, Uncertainty(dict.fromkeys(names, percent / 100.0)))
    seconds = time.process_time() - begin
    print(f"{folder.name}: {percent * claim.share:.3g} % proved, {seconds:.0f} s CPU", flush=True)
    print(f"  {', '.join(names)}{first_of(claim)}")
    return tried(prover, claim.proof, runs) if claim.proof.tube.steps else 0


def first_of(claim: Claim) -> str:
    """Say what could happen first under what was asked for."""
    first = claim.answer.first
    return "" if first is None else f"; beyond: t = {first.time:.3g} s, {first.what}"


def tried(prover: Prover, proof: TubeProof, runs: int) -> int:
    """Follow machines in the bounds of a proof, and return how many are outside its tube."""
    tube, scales = proof.tube, prover.problem.scales
    states = [executed(prover, proof.uncertainty, k, corner=k % 2 == 0) for k in range(runs)]
    wrong = sum(bool((outside(tube, x) > ROUNDING * scales).any()) for x in states)
    seen = np.ptp(states, axis=0)[: tube.steps + 1].max(axis=0)
    wide = (tube.bounds.high - tube.bounds.low).max(axis=0)
    moves = seen > ROUNDING * scales
    ratio = np.where(moves, wide / np.where(moves, seen, 1.0), 0.0)
    name = prover.problem.model.state_names[int(ratio.argmax())]
    print(
        f"  {wrong} of {runs} outside; {np.median(ratio[moves]):.2f} times as wide as seen, "
        f"at most {ratio.max():.2f} ({name})"
    )
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
