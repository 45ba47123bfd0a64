"""A gain matrix, from wherever it comes, as the feedback of a machine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import sympy
from numpy.typing import ArrayLike

from kinolab.arguments import require_fit, require_numbers
from kinolab.dynamics.analysis.trim import symbols_of_state
from kinolab.dynamics.language.feedback import Feedback, Reference
from kinolab.dynamics.language.inputs import Limit
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.model.units import state_units
from kinolab.errors import InputError, Mistake, unknown_name

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
    require_fit("with_gain references", Mapping[str, Any], references)
    mistakes = list(_mistakes(model, references))
    shapes = {"gain": (gain, (model.nu, model.nx)), "x": (x, (model.nx,))}
    shapes |= {"u": (u if np.size(u) else np.zeros(model.nu), (model.nu,))}
    arrays = []
    for name, (values, shape) in shapes.items():
        try:
            arrays.append(require_numbers(f"with_gain {name}", values, shape))
        except InputError as error:
            mistakes += error.mistakes
    if mistakes:
        raise InputError(mistakes)
    K, held, inputs = arrays
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


def _mistakes(model: Model, references: Mapping[str, Limit]) -> Iterator[Mistake]:
    where = "with_gain references"
    for name in references:
        if name not in model.state_names:
            yield unknown_name("state", name, known=model.state_names, where=where)
    if not references:
        remedy = f"Name states whose set points planners choose: {', '.join(model.state_names)}."
        yield Mistake(where, "there are none.", remedy)
