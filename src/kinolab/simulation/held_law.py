"""Is a controller, held for a step, stable? The closed loop as the map from one step to the next.

A law is evaluated at the beginning of each step and held to its end. A deviation from a steady
motion becomes (F_x + F_u K) times itself in a step, where F is the step of the machine without its
law, and K the law's derivative. With a multiplier beyond 1 it grows, though the law would make it
fade if it acted at every moment: such a law is too stiff for its step.

Source: Astrom, Wittenmark, Computer-Controlled Systems, 3rd ed., 1997, sections 3.2 and 4.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.stability import fastest_rate, step_too_long

if TYPE_CHECKING:  # a machine that is in the cache needs no symbols
    from kinolab.dynamics.language.mechanism import Mechanism

GROWING = 1.02  # multiplier from which a deviation grows; double roots at 1 are rounded by less


@dataclass(frozen=True)
class StiffLaw:
    """A law that is too stiff for its step.

    Attributes:
        step: How long it is held, in [s].
        multiplier: The largest one of a deviation over a step.
        holds: The longest step in [s], a half or a quarter or …, in which it is at most 1.
        gentler: By how much larger the deviations that a regulator tracks would have to be at this
            step; None of a law that is no regulator, or where none helps.
    """

    step: float
    multiplier: float
    holds: float
    gentler: float | None = None

    @property
    def sentence(self) -> str:
        """The mistake and its remedies, in words."""
        weights = ""
        if self.gentler is not None:
            weights = (
                f", or a regulator whose tracked deviations are {self.gentler:g} times as large"
            )
        return (
            f"The law is too stiff for its step: held for {self.step:.4g} s, it makes a deviation "
            f"{self.multiplier:.3g} times as large from one step to the next, and no motion "
            f"settles. It holds with [integration] step = {self.holds:.4g}{weights}."
        )


def law_sentence(
    model: Model, settings: IntegrationSection, described: Callable[[], Mechanism]
) -> str:
    """Return why a machine's law does not hold it, and what to do; empty if it does.

    A law that pushes the wrong way is not too stiff for its step: no step is short enough.
    Arguments as of ``stiff_law``.
    """
    if wrong := wrong_law(model, settings):
        return wrong
    found = stiff_law(model, settings, described)
    return "" if found is None else found.sentence


def stiff_law(
    model: Model, settings: IntegrationSection, described: Callable[[], Mechanism]
) -> StiffLaw | None:
    """Return why a machine's law does not hold at its step; None if it does, or there is none.

    Args:
        model: The machine with its law.
        settings: How it is integrated.
        described: Returns the machine as its author wrote it; called if its law is too stiff.
    """
    if model.machine.references is None or model.machine.modes:
        return None
    step = settings.step
    try:
        if step_too_long(settings, fastest_rate(model)) is not None:
            return None  # the method itself makes deviations grow, which is told elsewhere
        found = largest_multiplier(model, settings, step)
        if found <= GROWING:
            return None
        for short in step * 0.5 ** np.arange(1, 9):  # halvings of a step until the law holds
            if largest_multiplier(model, settings, short) <= GROWING:
                return StiffLaw(step, found, float(short), _gentler(described(), settings))
    except KinolabError:  # where the equations are singular, other checks say so
        return None
    return None


def wrong_law(model: Model, settings: IntegrationSection) -> str:
    """Return why a law makes deviations grow however often it acts; empty if it does not.

    A law that leaves an instability of the machine as it is may be meant so: growth counts that is
    faster than without the law.
    """
    if model.machine.references is None or model.machine.modes:
        return ""
    try:
        for x, r in _steady(model, settings):
            u = model.plant_inputs(x, r)
            own = _growth(model.plant.jacobian(x[: model.plant.nx], u)[0])
            growth = _growth(model.jacobian(x, r)[0])
            if growth > max(own, 0.0) + math.log(GROWING) / settings.step:
                return (
                    f"The law does not hold the machine, however short its step: a deviation from "
                    f"a steady motion grows {math.exp(min(growth, 100.0) * 0.1):.3g} times as "
                    f"large in 0.1 s, and without the law only "
                    f"{math.exp(max(own, 0.0) * 0.1):.3g} times. It pushes away from where it "
                    f"should hold: is the sign of its gains wrong?"
                )
    except KinolabError:  # where the equations are singular, other checks say so
        pass
    return ""


def _growth(slope: Array) -> float:
    """Return the largest growth rate in [1/s] of a linear system, shape (n, n)."""
    return float(np.linalg.eigvals(slope).real.max(initial=-math.inf))


def largest_multiplier(model: Model, settings: IntegrationSection, step: float) -> float:
    """Return the largest multiplier of a deviation over a step, at steady motions.

    Args:
        model: The machine with its law.
        settings: The method of integration and its substeps.
        step: In [s].
    """
    places = _steady(model, settings)
    return max((_multiplier(model, x, r, settings, step) for x, r in places), default=0.0)


def _multiplier(
    model: Model, x: Array, r: Array, settings: IntegrationSection, step: float
) -> float:
    """Return the spectral radius of the derivative of a step, by central differences."""
    h = 1e-5 * model.state_scales  # of a state's scale, for finite differences of a step
    shifts = np.diag(h)
    ends = [
        model.step(x + sign * shifts, np.tile(r, (model.nx, 1)), step,
                   method=settings.method, substeps=settings.substeps)
        for sign in (1.0, -1.0)
    ]  # fmt: skip
    slope = ((ends[0] - ends[1]) / (2 * h[:, None])).T
    if not np.isfinite(slope).all():
        return math.inf
    return float(np.abs(np.linalg.eigvals(slope)).max(initial=0.0))


def _steady(model: Model, settings: IntegrationSection) -> Iterator[tuple[Array, Array]]:
    """Yield the motions to which a machine settles under some references, in short steps.

    Those count that settle in which no input is at its limit: there the law does nothing.
    """
    lower, upper = model.control_bounds.T
    short = settings.step * 0.5**4
    limits = model.plant.control_bounds
    for share in (None, 0.5, 0.9, 0.1):
        r = model.null_control() if share is None else lower + share * (upper - lower)
        steps = round(4.0 / short)  # [s] that a machine is given to come to its steady motion
        try:
            x = model.steps(
                model.rest(), np.tile(r, (steps, 1)), np.full(steps, short), method=settings.method
            )[-1]
            u = model.plant_inputs(x, r)
        except KinolabError:
            continue
        inside = (u > limits[:, 0] + 1e-6).all() and (u < limits[:, 1] - 1e-6).all()
        if np.isfinite(x).all() and inside:
            yield x, r


def _gentler(system: Mechanism, settings: IntegrationSection) -> float | None:
    """Return by how much a regulator's tracked deviations must be larger to hold at a step."""
    from kinolab.dynamics.analysis.lqr_design import with_law
    from kinolab.dynamics.language.feedback import Regulator

    regulator = system.feedback
    if not isinstance(regulator, Regulator):
        return None

    for factor in (2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0):  # factors on large deviations
        softer = Regulator(
            regulator.references,
            tracked=[(z, factor * large) for z, large in regulator.tracked],
            about=regulator.about,
            efforts=regulator.efforts,
            schedule=regulator.schedule,
        )
        model = Model(with_law(system.with_feedback(softer)))
        if 0.0 < largest_multiplier(model, settings, settings.step) <= GROWING:
            return factor
    return None
