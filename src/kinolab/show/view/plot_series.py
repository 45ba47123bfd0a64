"""States, inputs and references of a plan as plots, with the units that the machine gives them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.dynamics.units import control_units, state_units
from kinolab.show.page import Series
from kinolab.trajectory import Trajectory


def plotted(model: Model, trajectory: Trajectory) -> list[Series]:
    """Return what is plotted of a plan: its states, then what is held from knot to knot."""
    found = [Series("States", trajectory.state_names, state_units(model), trajectory.x)]
    if len(trajectory.u):
        found.append(_held("Inputs", model.plant, trajectory.u))
        if trajectory.reference_names:
            found.append(_held("References", model, trajectory.references))
    return found


def _held(title: str, model: Model, values: NDArray[np.float64]) -> Series:
    return Series(title, model.control_names, control_units(model), values, held=True)
