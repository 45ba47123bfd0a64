"""Linearised machines as state spaces of python-control."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinolab.arguments import require_numbers
from kinolab.dynamics.model.model import Model
from kinolab.lazy import library_of


def control_system(model: Model, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Any:
    """Return the linearisation of a machine as a ``control.StateSpace`` with names.

    Its states and inputs are deviations from x and u, its outputs all states. About a point that
    is no equilibrium the constant rate f(x, u) is not part of it.

    Args:
        x: State, shape (nx,).
        u: Inputs, shape (nu,); zero when left out.
        parameters: Values that differ from the machine's own.

    Raises:
        InputError: If python-control is not installed, or a shape does not fit.
        SingularError: Where the equations of motion have no unique solution.
    """
    control = library_of("control", "control", "state spaces of python-control need it")
    at = require_numbers("to_control x", x, (model.nx,))
    held = require_numbers("to_control u", u, (model.nu,)) if np.size(u) else ()
    by_x, by_u = model.jacobian(at, held, **parameters)
    return control.ss(
        by_x,
        by_u,
        np.eye(model.nx),
        np.zeros((model.nx, model.nu)),
        states=list(model.state_names),
        inputs=list(model.control_names),
        outputs=list(model.state_names),
        name=model.machine.name,
    )
