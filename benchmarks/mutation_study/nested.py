"""Requirements of nested terms that a narrow place breaks, or just does not, by closed forms.

A cart passes it evenly, x = t. Windows are 1 at the place and less beside it, and so are products,
means, maxima and minima of windows: a requirement ``room - window`` is met if room is at least 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import kinolab
from kinolab.dynamics import Body, Rate, System, length, move, parameter, require
from kinolab.trajectory import Trajectory

from .faults import Case, Fault, Generator
from .judge import Verdict

WIDTHS = (-9.0, -1.0)  # decades in [m]
WAY, DEEPEST = 4.0, 3  # [m], nested terms
LACKS = (0.05, 1.0)  # by which it is broken; a hundredth of the terms, of 2 in all, may be missed
MORE = (-1.0, 1.0)  # by which it is more than just met; half of them just are
ROWS = 4  # at most
WINDOWS = (
    lambda s: sympy.Max(0, 1 - abs(s)),
    lambda s: sympy.Max(0, 1 - s**2),
    lambda s: sympy.exp(-abs(s)),
    lambda s: sympy.exp(-(s**2)),
    lambda s: (sympy.sign(s + 1) - sympy.sign(s - 1)) / 2,
    lambda s: abs(1 + sympy.Max(-abs(s), -1)),
    lambda s: -sympy.Max(-sympy.Max(0, 1 + s), -sympy.Max(0, 1 - s)),
)
TOGETHER = (
    lambda a, b: a * b,
    lambda a, b: (a + b) / 2,
    sympy.Max,
    lambda a, b: -sympy.Max(-a, -b),
    lambda a, b: sympy.exp(a + b - 2),
)


def requirement(seed: int, number: int) -> Fault:
    """Return the broken one of a number if it is even, else the same one kept."""
    generator = np.random.default_rng([seed, number // 2])
    return kept(None, generator) if number % 2 else broken(None, generator)


def broken(_case: Case | None, generator: Generator) -> Fault:
    """Let a cart pass a place that breaks its requirement by a good part of its terms."""
    return _passed(generator, 1.0 - float(generator.uniform(*LACKS)), Verdict("false", "its form"))


def kept(_case: Case | None, generator: Generator) -> Fault:
    """Let a cart pass a place where its requirement is just met, or better."""
    room = 1.0 + max(0.0, float(generator.uniform(*MORE)))
    return _passed(generator, room, Verdict("true", "its form"))


def _passed(generator: Generator, room: float, verdict: Verdict) -> Fault:
    x, place = length("x", -10, 10, speed=3.0), float(generator.uniform(0.1, 0.9)) * WAY
    window = window_at(generator, x - place, int(generator.integers(DEEPEST + 1)))
    margin = parameter("room", room)  # so that one broken and one kept have the same code
    machine = System(
        "cart",
        bodies=[Body("cart", move(x, 0, 0))],
        inputs=[Rate("v", on=x, limit=2.0)],
        requirements=[require(margin - window, "room")],
    )
    table: dict[str, Any] = {"system": machine, "goal": {"x": WAY, "tolerance": 0.1}}
    problem = kinolab.load(table)
    inner = generator.uniform(0.0, WAY, int(generator.integers(ROWS)))
    t = np.concatenate([[0.0], np.sort(inner), [WAY]])
    names = problem.model.state_names, problem.model.control_names
    motion = Trajectory(t, t[:, None], np.ones((len(t) - 1, 1)), *names)
    return Fault(problem, motion, verdict, f"{room:.9g} - {window}"[:200])


def window_at(generator: Generator, s: sympy.Expr, depth: int) -> sympy.Expr:
    """Return a window of random terms: 1 where s is 0, and nowhere more."""
    if not depth:
        width = float(10 ** generator.uniform(*WIDTHS))
        return WINDOWS[int(generator.integers(len(WINDOWS)))](s / width)
    one, other = (window_at(generator, s, depth - 1) for _ in range(2))
    return TOGETHER[int(generator.integers(len(TOGETHER)))](one, other)
