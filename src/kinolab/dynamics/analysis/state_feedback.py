"""A gain matrix, from wherever it comes, as the feedback of a machine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import sympy
from numpy.typing import ArrayLike

from kinolab.dynamics.analysis.trim import symbols_of_state
from kinolab.dynamics.language.feedback import Feedback, Reference
from kinolab.dynamics.language.inputs import Limit
from kinolab.dynamics.model import Model
from kinolab.dynamics.units import state_units
from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.numerics.arrays import Array

SET_POINT = "_set"  # ends the name of a reference


def state_feedback(
    model: Model,
    gain: ArrayLike,
    x: ArrayLike,
    u: ArrayLike = (),
    *,
    references: Mapping[str, Limit],
) -> Feedback:
    """Return the law u - K (x_now - x), in which some entries of x are chosen by planners.

    Args:
        model: The machine, without feedback.
        gain: K, shape (nu, nx), such as ``control.lqr`` returns it.
        x: The state that is held, shape (nx,).
        u: The inputs that hold it, shape (nu,); zero when left out.
        references: Limits of the set points, by the names of the states; the one of ``x`` is called
            ``x_set``.

    Raises:
        InputError: With everything that does not fit.
    """
    K, held = np.asarray(gain, dtype=float), np.asarray(x, dtype=float)
    inputs = np.asarray(u, dtype=float) if np.size(u) else np.zeros(model.nu)
    if mistakes := list(_mistakes(model, K, held, inputs, references)):
        raise InputError(mistakes)
    units = dict(zip(model.state_names, state_units(model), strict=True))
    points = {
        name: Reference(f"{name}{SET_POINT}", limit=limit, unit=units[name])
        for name, limit in references.items()
    }
    wanted = [
        points[name].symbol if name in points else sympy.Float(value)
        for name, value in zip(model.state_names, held.tolist(), strict=True)
    ]
    deviations = [s - at for s, at in zip(symbols_of_state(model), wanted, strict=True)]
    law = {
        name: constant - sum(k * d for k, d in zip(row, deviations, strict=True) if k)
        for name, constant, row in zip(
            model.control_names, inputs.tolist(), K.tolist(), strict=True
        )
    }
    return Feedback(list(points.values()), law)


def _mistakes(
    model: Model, K: Array, x: Array, u: Array, references: Mapping[str, Limit]
) -> Iterator[Mistake]:
    where = f"feedback of {model.machine.name!r}"
    shapes = {"gain": (K, (model.nu, model.nx)), "x": (x, (model.nx,)), "u": (u, (model.nu,))}
    for name, (array, wanted) in shapes.items():
        if array.shape != wanted:
            yield Mistake(where, f"{name} has shape {array.shape}; it must be {wanted}.")
        elif not np.isfinite(array).all():
            yield Mistake(where, f"{name} is not finite.")
    for name in references:
        if name not in model.state_names:
            yield unknown_name("state", name, known=model.state_names, where=where)
    if not references:
        remedy = f"Name states whose set points planners choose: {', '.join(model.state_names)}."
        yield Mistake(where, "it has no references.", remedy)
