"""From definition to compiled equations of motion, and the cost of one evaluation.

    python benchmarks/dynamics.py [--sympy] [--repeat N]

Prints Markdown tables. Cold and warm are apart: cold begins with an empty cache of machines, warm
finds the machine there; imports are left out of both. One evaluation is timed in a compiled loop
over random states, and as a batch from Python. Beside it stand SymPy's LagrangesMethod with
lambdify (``--sympy``: minutes) and, called from Python, Pinocchio's articulated-body algorithm on
a chain of as many joints.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from kinolab import systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Model,
    System,
    Torque,
    angle,
    length,
    move,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
)
from kinolab.dynamics.lagrange.energies import kinetic_energy, weight_energy

STATES = 20_000
HEADINGS = (
    *("machine", "cold [s]", "limit", "warm [ms]", "limit"),
    *("f [ns]", "limit", "batch", "Pinocchio [ns]"),
)


def double_pendulum() -> System:
    """Two rods on universal joints: 4 coordinates."""
    a = [angle(f"a{i}") for i in range(4)]
    upper = rot_x(a[0]) @ rot_y(a[1]) @ move(0, 0, -0.5)
    lower = upper @ move(0, 0, -0.5) @ rot_x(a[2]) @ rot_y(a[3]) @ move(0, 0, -0.5)
    rods = [
        Body(name, frame, mass=1.0, inertia=(0.1, 0.1, 0.01))
        for name, frame in (("upper", upper), ("lower", lower))
    ]
    shoulder = Torque("shoulder", on=rods[0], about=WORLD.x, limit=1.0)
    return System("double_pendulum", bodies=rods, gravity=toward("-z"), inputs=[shoulder])


def marionette() -> System:
    """The built-in puppet on ropes without its puppeteer."""
    return systems.get("marionette").with_feedback(None)


def free_body(links: int) -> System:
    """A body with ZYX Euler angles and a chain of links: 6 + links coordinates."""
    x, y, z = length("x"), length("y"), length("z")
    yaw, pitch, roll = angle("yaw"), angle("pitch"), angle("roll")
    g = move(x, y, z) @ rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)
    bodies = [Body("base", g, mass=5.0, inertia=(0.3, 0.4, 0.5))]
    for i in range(links):
        turn = rot_y if i % 2 else rot_x
        g = g @ move(0, 0, -0.3) @ turn(angle(f"q{i}")) @ move(0, 0, -0.3)
        bodies.append(Body(f"link{i}", g, mass=1.0, inertia=(0.05, 0.05, 0.005)))
    push = Force("push", on=bodies[0], along=WORLD.x, limit=1.0)
    return System(f"free_{links}", bodies=bodies, gravity=toward("-z"), inputs=[push])


# The machine, and the figures to reach: [s] cold, [ms] warm, [ns] per evaluation.
MACHINES: dict[str, tuple[Callable[[], System], tuple[float, float, float]]] = {
    "double pendulum 3-D": (double_pendulum, (0.5, 50.0, 500.0)),
    "free body, 2 links": (lambda: free_body(2), (1.0, 50.0, 800.0)),
    "free body, 6 links": (lambda: free_body(6), (4.0, 50.0, 4000.0)),
    # Four evaluations are a step of Runge and Kutta's, of 50 us at most.
    "marionette, 28 coordinates": (marionette, (5.0, 50.0, 12_500.0)),
}


def timed(action: Callable[[], Any]) -> float:
    """Return the seconds that an action takes."""
    begun = time.perf_counter()
    action()
    return time.perf_counter() - begun


def median(action: Callable[[], Any], repeat: int) -> float:
    """Return the median of several timings, in [s]."""
    return statistics.median(timed(action) for _ in range(repeat))


def build_times(make: Callable[[], System], repeat: int) -> tuple[float, float]:
    """Return the seconds from definition to a compiled f, cold and warm."""
    cold, warm = [], []
    for _ in range(repeat):
        with tempfile.TemporaryDirectory() as folder:
            os.environ["KINOLAB_CACHE"] = folder
            cold.append(timed(lambda: make().model()))
            warm.append(timed(lambda: make().model()))
    del os.environ["KINOLAB_CACHE"]
    return statistics.median(cold), statistics.median(warm)


def evaluation_times(model: Model, repeat: int) -> tuple[float, float]:
    """Return nanoseconds per evaluation in a compiled loop, and as a batch from Python."""
    generator = np.random.default_rng(0)
    x = generator.uniform(-1, 1, (STATES, model.nx))
    u = generator.uniform(-1, 1, (STATES, model.nu))
    p, out = model.parameter_vector(), np.empty_like(x)
    loop = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * 5, *[ctypes.c_int64] * 3)(
        model.address("rows_under")
    )
    arguments = [array.ctypes.data for array in (x, u, p, out)]

    def compiled() -> None:
        if loop(model.address("f"), *arguments, STATES, model.nx, 0) != -1:
            raise ArithmeticError("a state has no solution")

    compiled()
    model.f(x, u)
    per_state = 1e9 / STATES
    return median(compiled, repeat) * per_state, median(lambda: model.f(x, u), repeat) * per_state


def sympy_times(make: Callable[[], System]) -> tuple[float, float]:
    """Return seconds to derive and lambdify, and nanoseconds per evaluation from Python.

    The Lagrangian is stated from the same energies and given to SymPy's LagrangesMethod, whose
    mass matrix and forcing are lambdified with common subexpressions and solved by NumPy.
    """
    import sympy
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    system = make()
    q = [dynamicsymbols(c.name) for c in system.coordinates]
    q_dot = [symbol.diff(dynamicsymbols._t) for symbol in q]
    known = dict(zip(map(rate, system.coordinates), q_dot, strict=True))
    known |= dict(zip(system.coordinates, q, strict=True))
    energy = (kinetic_energy(system) - weight_energy(system)).xreplace(known)
    begun = time.perf_counter()
    method = LagrangesMethod(energy, q)
    method.form_lagranges_equations()
    plain = [sympy.Symbol(f"s{i}") for i in range(2 * len(q))]
    # Rates first: replacing a coordinate would make the rate a derivative of a plain symbol.
    order = dict(zip([*q_dot, *q], [*plain[len(q) :], *plain[: len(q)]], strict=True))
    function = sympy.lambdify(
        plain, [method.mass_matrix.subs(order), method.forcing.subs(order)], cse=True
    )
    spent = time.perf_counter() - begun
    point = np.random.default_rng(0).uniform(-1, 1, len(plain))
    return spent, median(lambda: np.linalg.solve(*function(*point)), 200) * 1e9


def pinocchio_time(model: Model) -> str:
    """Return nanoseconds per articulated-body call from Python, on a chain of as many joints."""
    try:
        import pinocchio
    except ImportError:
        return "-"
    chain, parent = pinocchio.Model(), 0
    joints = (pinocchio.JointModelRX, pinocchio.JointModelRY)
    offset = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, -0.3]))
    inertia = pinocchio.Inertia(1.0, np.array([0.0, 0.0, -0.3]), np.diag([0.05, 0.05, 0.005]))
    for i in range(model.nt):
        parent = chain.addJoint(parent, joints[i % 2](), offset, f"joint{i}")
        chain.appendBodyToJoint(parent, inertia, pinocchio.SE3.Identity())
    data, q = chain.createData(), np.full(chain.nq, 0.3)
    v, tau = np.full(chain.nv, 0.2), np.zeros(chain.nv)
    return f"{median(lambda: pinocchio.aba(chain, data, q, v, tau), 2000) * 1e9:.0f}"


def describe() -> str:
    """Return what this ran on."""
    from kinolab.studies.hardware import processor

    return f"{processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Time the derivation and the evaluation of f.")
    parser.add_argument("--sympy", action="store_true", help="time SymPy too")
    parser.add_argument("--repeat", type=int, default=5, help="timings per figure")
    options = parser.parse_args()
    double_pendulum().model()  # LLVM's own start is apart, like the imports
    print(f"{describe()}\n\n| {' | '.join(HEADINGS)} |\n{'|---' * len(HEADINGS)}|")
    for name, (make, limits) in MACHINES.items():
        cold, warm = build_times(make, options.repeat)
        model = make().model()
        single, batch = evaluation_times(model, 3 * options.repeat)
        cells = (
            *(name, f"{cold:.2f}", f"{limits[0]:g}", f"{1e3 * warm:.1f}", f"{limits[1]:g}"),
            *(f"{single:.0f}", f"{limits[2]:g}", f"{100 * (batch / single - 1):+.0f} %"),
            pinocchio_time(model),
        )
        print(f"| {' | '.join(cells)} |")
    if options.sympy:
        spent, cost = sympy_times(double_pendulum)
        print(
            f"\nSymPy, double pendulum 3-D: {spent:.1f} s to derive, {cost:.0f} ns per evaluation"
        )


if __name__ == "__main__":
    main()
