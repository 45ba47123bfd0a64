"""Plans of least effort and of least energy, against the quickest ones.

    python benchmarks/objectives.py vehicle_parking crane_factory --objective effort --seeds 1 2 3

For each scenario and seed the quickest motion is planned first. Then the same is planned by the
objective, with at most twice the shortest time that is known. Both are priced by the verifier's
integrator. The ratio is at most 1 unless the second one was not given enough work.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from pathlib import Path

import kinolab
from kinolab.simulation.reference import price

BEST = Path(__file__).parent / "best_known.toml"
CAP = 2.0  # times the shortest duration that is known


def main() -> None:
    """Print a line for each scenario, objective and seed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="+")
    parser.add_argument("--objective", nargs="+", default=["effort", "energy"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    given = parser.parse_args()
    best = tomllib.loads(BEST.read_text(encoding="utf-8"))
    for name in given.scenarios:
        for seed in given.seeds:
            problem = kinolab.load(name)
            quick, clock = problem.solve(seed=seed), time.perf_counter()
            for kind in given.objective:
                most = CAP * float(best[name])
                priced = problem.replace(objective={kind: 1.0, "max_time": most})
                cheap = priced.solve(seed=seed)
                before = quick.trajectory and price(priced, quick.trajectory)
                ratio = cheap.cost / before if cheap.cost and before else float("nan")
                print(
                    f"{name} {kind} seed {seed}: {cheap.status}, {cheap.cost or 0:.4g} in "
                    f"{cheap.duration or 0:.2f} s, the quickest {before or 0:.4g} in "
                    f"{quick.duration or 0:.2f} s, ratio {ratio:.3f}, "
                    f"{time.perf_counter() - clock:.0f} s",
                    flush=True,
                )


if __name__ == "__main__":
    main()
