"""False plans of several goals and of an objective for the verifier to refuse, and true ones.

    python benchmarks/goal_faults.py --faults 1000 --good 200 --seed 1

A puck without friction is pushed through goals at which it stays for a time, for little effort.
Inputs of its plan are changed at random, by bumps that cancel each other or don't, goals are moved,
swapped or held for longer, ``max_time`` and weights are changed, and another cost is told. Whether
the result is false is decided here, by the parabolas that a puck moves along, in closed form. What
is within a millionth of a limit is drawn anew. Ctrl-C ends it with a table of what is finished.
Returns 1 if anything false was accepted or anything true refused.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

import kinolab
from kinolab.numerics.arrays import Array
from kinolab.runs import check_run
from kinolab.trajectory import Trajectory

KINDS = ("bump", "cancelled", "moved", "order", "hold", "max_time", "weight", "told")
SURE = 1e-6  # of what limits are told in, how near to one nothing is drawn
ROUNDING = 1e-9  # of limits that good plans reach
PLACES = ((1.0, 0.5), (1.5, 2.0), (0.0, 2.5))
PUCK = """
from kinolab.dynamics import Body, Force, Sphere, System, length, move

def puck() -> System:
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    f = move(x, y, 0)
    b = Body("puck", f, mass=1.0, shape=Sphere(0.1))
    forces = [Force("px", on=b, along=f.x, limit=1.0), Force("py", on=b, along=f.y, limit=1.0)]
    return System("puck", bodies=[b], inputs=forces)
"""


@dataclass(frozen=True)
class Asked:
    """What a plan must do: places with how long it stays, all within ``near``, and what is told."""

    places: tuple[tuple[float, float], ...] = PLACES
    holds: tuple[float, ...] = (0.4, 0.3, 0.0)
    near: float = 0.05
    slow: float = 0.05  # [m/s] of each axis
    max_time: float = 20.0
    effort: float = 1.0
    time: float = 0.1

    def __str__(self) -> str:
        """Write the scenario."""
        goals = "".join(
            f"[[goal]]\nx = {x!r}\ny = {y!r}\nx_dot = 0.0\ny_dot = 0.0\nhold = {hold!r}\n"
            f"tolerance = {{ x = {self.near!r}, y = {self.near!r}, "
            f"x_dot = {self.slow!r}, y_dot = {self.slow!r} }}\n"
            for (x, y), hold in zip(self.places, self.holds, strict=True)
        )
        return (
            'schema = 1\ntitle = "A puck"\n[system]\nfile = "puck.py:puck"\n'
            "[bounds]\nx = [-6.0, 6.0]\ny = [-6.0, 6.0]\n[start]\nx = 0.0\ny = 0.0\n"
            f"[objective]\neffort = {self.effort!r}\ntime = {self.time!r}\n"
            f"max_time = {self.max_time!r}\n{goals}"
        )

    def cost(self, t: Array, u: Array) -> float:
        """Return what a motion costs."""
        h = np.diff(t)
        return float(self.effort * (h[:, None] * u**2).sum() + self.time * h.sum())


@dataclass(frozen=True, eq=False)
class Case:
    """A changed plan: what is asked, the inputs, the factor of the cost that is told, the truth."""

    kind: str
    asked: Asked
    u: Array
    told: float = 1.0
    right: bool = False


def moved(t: Array, u: Array) -> Array:
    """Return the states (x, y, vx, vy) at the knots of a puck that is pushed by u, from rest."""
    x = np.zeros((len(t), 4))
    for k, h in enumerate(np.diff(t)):
        p, v = x[k, :2], x[k, 2:]
        x[k + 1] = [*(p + h * v + 0.5 * h * h * u[k]), *(v + h * u[k])]
    return x


def within(asked: Asked, t: Array, u: Array, place: tuple[float, float], wider: float) -> Array:
    """Return the intervals (n, 2) of time in which the puck is in a goal, so much wider."""
    x, inside = moved(t, u), []
    for k, h in enumerate(np.diff(t)):
        if np.abs(x[k, :2] - place).max() > asked.near + h * (2.0 + h):
            continue  # at 2 m/s it does not come so far
        cuts = [0.0, h]
        for i in range(2):
            for side in (-1.0, 1.0):
                near = place[i] + side * (asked.near + wider) - x[k, i]
                cuts += np.roots([0.5 * u[k, i], x[k, 2 + i], -near]).tolist()
                cuts += np.roots([u[k, i], x[k, 2 + i] - side * (asked.slow + wider)]).tolist()
        real = sorted({float(c.real) for c in np.atleast_1d(cuts) if abs(np.imag(c)) < 1e-12})
        real = [c for c in real if 0.0 <= c <= h]
        for a, b in pairwise(real):
            m = 0.5 * (a + b)
            p = x[k, :2] + m * x[k, 2:] + 0.5 * m * m * u[k]
            v = x[k, 2:] + m * u[k]
            if np.all(np.abs(p - place) <= asked.near + wider) and np.all(
                np.abs(v) <= asked.slow + wider
            ):
                inside.append((t[k] + a, t[k] + b))
    joined: list[list[float]] = []
    for a, b in inside:
        if joined and a - joined[-1][1] < 1e-9:
            joined[-1][1] = b
        else:
            joined.append([a, b])
    return np.array(joined).reshape(-1, 2)


def solves(asked: Asked, t: Array, u: Array, wider: float) -> bool:
    """Say whether a motion does all that is asked, with limits that are so much wider."""
    x, now = moved(t, u), 0.0
    if t[-1] > asked.max_time + wider:
        return False
    for values, most in ((u, 1.0), (x[:, 2:], 2.0), (x[:, :2], 6.0)):  # which plans may reach
        if np.abs(values).max() > most + ROUNDING:
            return False
    for k, (place, hold) in enumerate(zip(asked.places, asked.holds, strict=True)):
        last = k == len(asked.places) - 1
        for a, b in within(asked, t, u, place, wider):
            begin = max(a, now)
            if last and b < t[-1] - ROUNDING:
                continue  # the motion's end is no limit that it might keep by more or less
            if begin + hold <= (float(t[-1]) if last else b) + wider:
                now = begin + hold
                break
        else:
            return False
    return True


def fault(rng: np.random.Generator, asked: Asked, t: Array, u: Array) -> Case:
    """Return a plan that is changed in one way."""
    kind, size = str(rng.choice(KINDS)), 10.0 ** rng.uniform(-4.0, 0.0)
    k, i = int(rng.integers(0, len(u) - 3)), int(rng.integers(0, 2))
    changed, told = u.copy(), 1.0
    match kind:
        case "bump":
            changed[k, i] += rng.choice([-1.0, 1.0]) * size
        case "cancelled":  # leaves place and speed as they were where steps are equal
            h = np.diff(t)[k : k + 3]
            if np.ptp(h) < 1e-12:
                changed[k : k + 3, i] += size * np.array([1.0, -2.0, 1.0]) * 0.2
        case "moved":
            at = int(rng.integers(0, len(asked.places)))
            places = [*asked.places]
            places[at] = tuple(np.add(places[at], size * rng.normal(size=2)).tolist())
            asked = replace(asked, places=tuple(places))
        case "order":
            order = rng.permutation(len(asked.places))
            asked = replace(asked, places=tuple(asked.places[j] for j in order))
        case "hold":
            at = int(rng.integers(0, len(asked.holds)))
            holds = [*asked.holds]
            holds[at] = max(0.0, float(holds[at] + rng.choice([-1.0, 1.0]) * size))
            asked = replace(asked, holds=tuple(holds))
        case "max_time":
            asked = replace(asked, max_time=float(t[-1] + rng.choice([-1.0, 1.0]) * size))
        case "weight":
            asked = replace(asked, effort=asked.effort * (1.0 + size))
        case "told":
            told = 1.0 + rng.choice([-1.0, 1.0]) * 0.1 * size
    return Case(kind, asked, changed, told)


def drawn(rng: np.random.Generator, asked: Asked, t: Array, u: Array) -> Iterator[Case]:
    """Yield changed plans of which it is sure whether they are false."""
    while True:
        case = fault(rng, asked, t, u)
        barely = solves(case.asked, t, case.u, SURE)
        strictly = barely and solves(case.asked, t, case.u, -SURE)
        if strictly is barely:
            yield replace(case, right=bool(strictly and case.told == 1.0))


def accepted(folder: Path, run: Path, case: Case, plan: Trajectory) -> bool:
    """Say whether the verifier accepts a case, and what it costs by the closed form."""
    if case.told != 1.0:
        report = json.loads((run / "report.json").read_text(encoding="utf-8"))
        report["cost"] *= case.told
        told = folder / "told"
        shutil.copytree(run, told, dirs_exist_ok=True)
        (told / "report.json").write_text(json.dumps(report), encoding="utf-8")
        return check_run(told).passed
    (folder / "asked.toml").write_text(str(case.asked), encoding="utf-8")
    problem = kinolab.load(folder / "asked.toml")
    motion = replace(plan, x=moved(plan.t, case.u), u=case.u)
    certificate = kinolab.verify(problem, motion)
    cost = case.asked.cost(plan.t, case.u)
    return certificate.passed and abs((certificate.cost or 0.0) - cost) <= 1e-9 * cost


def main() -> int:
    """Print a table; return 1 if anything was judged wrongly."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=1000)
    parser.add_argument("--good", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng, asked = np.random.default_rng(given.seed), Asked()
    left = {False: given.faults, True: given.good}
    made, wrong = Counter[tuple[str, bool]](), Counter[tuple[str, bool]]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "puck.py").write_text(PUCK, encoding="utf-8")
        (folder / "asked.toml").write_text(str(asked), encoding="utf-8")
        plan = kinolab.load(folder / "asked.toml").solve(seed=given.seed, improve=2)
        assert plan.status == "solved"
        assert plan.trajectory is not None
        run, motion = Path(plan.save(folder / "run")), plan.trajectory
        with suppress(KeyboardInterrupt):
            for case in drawn(rng, asked, motion.t, motion.u):
                if not any(left.values()):
                    break
                if left[case.right]:
                    found = accepted(folder, run, case, motion) is not case.right
                    left[case.right] -= 1
                    made[case.kind, case.right] += 1
                    wrong[case.kind, case.right] += found
                    if found:
                        words = f"{case.kind}, {case.asked}, told {case.told!r}"
                        print(f"judged wrongly: {words}", file=sys.stderr, flush=True)
    print("| change | false | of them accepted | true | of them refused |\n|---|---|---|---|---|")
    for kind in KINDS:
        counts = (f"{n[kind, right]}" for right in (False, True) for n in (made, wrong))
        print(f"| {kind} | {' | '.join(counts)} |")
    both = [(n, right) for right in (False, True) for n in (made, wrong)]
    counts = (f"{sum(n[kind, right] for kind in KINDS)}" for n, right in both)
    print(f"| all | {' | '.join(counts)} |")
    return int(wrong.total() > 0)


if __name__ == "__main__":
    sys.exit(main())
