"""SymPy's own evaluation gives what the machine code gives."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy

from kinolab import systems
from kinolab.dynamics import rate
from kinolab.dynamics.translation import SympyModel
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from tests.dynamics.translation.test_translation import AGREE, MACHINES, agree, instants


def evaluated(model: SympyModel, x: Array, u: Array) -> Array:
    """Return f at a state, as SymPy evaluates it in 30 digits."""
    with mpmath.workdps(30):
        values = {s: sympy.Float(str(v), 30) for s, v in model.values.items()}
        values |= {s: sympy.Float(repr(float(v)), 30) for s, v in zip(model.x, x, strict=True)}
        values |= {s: sympy.Float(repr(float(v)), 30) for s, v in zip(model.u, u, strict=True)}
        for symbol, expression in model.replacements:
            values[symbol] = expression.xreplace(values).evalf(30)
        return np.array([float(entry.xreplace(values).evalf(30)) for entry in model.f])


@pytest.mark.parametrize("name", MACHINES)
def test_thirty_digits_agree(name: str) -> None:
    system = systems.get(name)
    model, told = system.model(), system.to_sympy()
    assert (len(told.x), len(told.u)) == (model.nx, model.nu)
    for x, u in instants(model):
        agree(evaluated(told, x, u), model.f(x, u))


def test_a_pendulum_s_equation_is_that_of_the_textbook() -> None:
    system = systems.get("pendulum")
    told = system.to_sympy()
    theta, speed = told.x
    m, length, g = (sympy.Symbol(n, real=True, positive=True) for n in ("m", "l", "g"))
    names = {s.name: s for s in told.p}
    acceleration = told.expanded()[1].subs({names["m"]: m, names["l"]: length, names["g"]: g})
    assert told.expanded()[0] == speed
    free = acceleration.subs(dict.fromkeys(told.u, 0)).subs(speed, 0)
    slope = sympy.simplify(free.diff(theta).subs(theta, 0) * length / g)
    assert slope in (1, -1)  # whether theta is measured from below or from above
    assert rate(system.coordinates[0]) == speed


def test_large_machines_stay_small() -> None:
    told = systems.get("submarine").to_sympy()
    assert sum(e.count_ops() for _, e in told.replacements) < 5000
    assert repr(told).startswith("<SympyModel: 13 states, 3 inputs, ")


def test_feedback_is_refused() -> None:
    with pytest.raises(InputError, match="Translate its plant"):
        systems.get("unicycle").to_sympy()


assert AGREE < 1e-11
