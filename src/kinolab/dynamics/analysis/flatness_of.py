"""Which outputs of a machine are flat, given or found, and where it is known, why it is not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
import sympy

from kinolab.arguments import checked
from kinolab.dynamics.analysis.equilibrium import equilibrium
from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.analysis.flat.given_map import without_friction, wrong_map
from kinolab.dynamics.analysis.flat.hanging_inverse import hanging_map
from kinolab.dynamics.analysis.flat.not_flat import why_not_flat
from kinolab.dynamics.analysis.flat.output_candidates import AXES, Candidate
from kinolab.dynamics.analysis.flat.output_search import OutputSearch, ProvedOutputs
from kinolab.dynamics.analysis.flat.plane_inverse import plane_curves
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.flatness import Flat, FlatOutputs, PlaneCurves, output
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import require_one_mode
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.errors import row_of


class Flatness(Enum):
    """What is known; the value begins the sentence that says so."""

    FLAT = "flat"
    NOT_FLAT = "not flat"
    UNDECIDED = "not known to be flat"


@checked
@dataclass(frozen=True)
class FlatOutput:
    """A flat output.

    Attributes:
        said: What it is, in words.
        expression: It in coordinates and parameters.
        order: Number of its derivatives that states and inputs need.
    """

    said: str
    expression: sympy.Expr
    order: int


@checked
@dataclass(frozen=True)
class FlatnessFound:
    """What is known of the flatness of a machine.

    Attributes:
        flatness: Whether it is flat; proved where it is said.
        outputs: Its flat outputs, as many as inputs; none where none are known.
        given: Whether they are those that the machine says it has.
        left_over: Names of states that they do not determine and on which nothing depends, such as
            how far a wheel has rolled.
        idle: Names of inputs that may be anything besides, as others act alike.
        neglected: Forces without which the outputs are flat, in words; with them, none are known.
        reason: Why it is not flat, or what was tried.
        singular: Where derivatives up to these orders do not suffice, as far as that is known.
        margin: Smallest singular value of the ranks that prove it, relative to the largest.
        inverse: Coordinates as functions of the outputs, for steering; None where these have no
            closed form that is known.
    """

    flatness: Flatness
    outputs: tuple[FlatOutput, ...] = ()
    given: bool = False
    left_over: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    neglected: tuple[str, ...] = ()
    reason: str = ""
    singular: str = ""
    margin: float = 0.0
    inverse: Flat | None = None

    def __str__(self) -> str:
        """What ``plan describe`` says of it."""
        if not self.outputs:
            return f"{self.flatness.value}: {self.reason}"
        begin = "flat if friction is neglected" if self.neglected else "flat"
        orders = [_ordinal(one.order) for one in self.outputs]
        same = len(set(orders)) == 1
        to = f"{orders[0] if same else row_of(orders)} derivative{'s' * (len(orders) > 1)}"
        text = f"{begin}: {self._row()}, to {'its' if len(orders) == 1 else 'their'} {to}"
        if self.left_over:
            text += f"; this leaves {row_of(self.left_over)} free, on which nothing depends"
        if self.idle:
            text += f"; {row_of(self.idle)} can be anything besides"
        if self.singular:
            text += f"; singular {self.singular}"
        return f"{text} ({'given' if self.given else 'found'})"

    def _row(self) -> str:
        """Name the outputs; entries of one point together."""
        entries: dict[str, list[str]] = {}
        for one in self.outputs:
            entry, _, point = one.said.partition(" of ")
            known = bool(point) and entry in AXES
            entries.setdefault(point if known else one.said, []).extend([entry] * known)
        return row_of(f"{row_of(own)} of {what}" if own else what for what, own in entries.items())


@checked
def flatness_of(system: Mechanism) -> FlatnessFound:
    """Return what is known of the flatness of a machine.

    Outputs are called flat only where the dynamic extension algorithm proves it, at random states
    with clear ranks, and a machine is called not flat only by a theorem. So a machine of which
    neither is said may be flat all the same.

    Args:
        system: The machine; of one with modes, ``in_mode`` gives what can be examined. Its feedback
            is left out, which changes nothing.

    Raises:
        InputError: If it cannot be derived, or has modes.
    """
    require_one_mode(system)
    plant = system.with_feedback(None)
    if not plant.inputs:
        return FlatnessFound(Flatness.NOT_FLAT, reason="it has no inputs")
    try:
        with np.errstate(all="ignore"):  # what is not finite has no rank, and raises
            return _of_plant(ControlSystem.of(plant))
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        what = f"its equations have no series at the states that were tried ({error})"
        return FlatnessFound(Flatness.UNDECIDED, reason=what)


def _of_plant(control: ControlSystem) -> FlatnessFound:
    """Return what is known of a machine, or else of it without friction."""
    plant, model = control.system, control.model
    search = OutputSearch(control, equilibrium(model, model.rest(), polish=True))
    first = _of_machine(control, search)
    if first.outputs or first.flatness is Flatness.NOT_FLAT:
        return first
    kept = without_friction(plant)
    if len(kept) == len(plant.efforts) or (search.exhausted and plant.flat is None):
        return first
    smooth = ControlSystem.of(plant.changed(efforts=kept), model)
    second = _of_machine(smooth, OutputSearch(smooth))
    return _neglecting(second, plant) if second.outputs else first


def _of_machine(control: ControlSystem, search: OutputSearch) -> FlatnessFound:
    """Return what is known of a machine with all its forces."""
    system = control.system
    if system.flat is not None and (found := search.proved(_given(control, system.flat))):
        inverse = None if wrong_map(control) else system.flat
        return _told(control, found, given=True, inverse=inverse)
    if found := search.found():
        return _told(control, found, given=False, inverse=_inverse(control, found))
    if reason := why_not_flat(control):
        return FlatnessFound(Flatness.NOT_FLAT, reason=reason)
    tried = (
        f"none of {search.tried} sets of coordinates and points that were tried is a flat output"
    )
    short = "" if search.finished else ", as far as this was computed"
    return FlatnessFound(Flatness.UNDECIDED, reason=tried + short)


def _given(control: ControlSystem, flat: Flat) -> tuple[Candidate, ...]:
    """Return the outputs of a flat map as candidates."""
    fields = control.fields
    named = {s.name: s for s in (*fields.symbols, *fields.constants)}
    bound = {symbol: control.tape.variable(name) for name, symbol in named.items()}
    lower = Lowering(control.tape, bound)
    pairs = (
        [(c.name, c) for c in (flat.x, flat.y)] if isinstance(flat, PlaneCurves) else flat.outputs
    )
    return tuple(Candidate(lower(formula), name, formula) for name, formula in pairs)


def _told(
    control: ControlSystem, found: ProvedOutputs, *, given: bool, inverse: Flat | None
) -> FlatnessFound:
    outputs = tuple(
        FlatOutput(one.said, one.expression, order)
        for one, order in zip(found.outputs, found.orders, strict=True)
    )
    return FlatnessFound(
        Flatness.FLAT,
        outputs,
        given,
        found.left_over,
        tuple(entry.name for entry in control.idle),
        singular="at rest" if found.at_rest is False else "",
        margin=found.margin,
        inverse=inverse,
    )


def _inverse(control: ControlSystem, found: ProvedOutputs) -> Flat | None:
    """Return coordinates as functions of the outputs, as far as that is known."""
    symbols = [one.symbol for one in found.outputs]
    own = [symbol for symbol in symbols if isinstance(symbol, Coordinate)]
    if set(own) != set(control.system.coordinates):
        curves = plane_curves(control, symbols, found.left_over)
        return curves or hanging_map(control, found.outputs)
    named = tuple((f"{symbol.name}_flat", symbol) for symbol in own)
    return FlatOutputs(named, tuple((symbol, output(name)) for name, symbol in named))


def _neglecting(found: FlatnessFound, system: Mechanism) -> FlatnessFound:
    """Return what is known without friction, as what it is."""
    kept = without_friction(system)
    friction = tuple(str(effort) for effort in system.efforts if effort not in kept)
    reason = "these outputs are flat without friction only"
    return replace(found, flatness=Flatness.UNDECIDED, neglected=friction, reason=reason)


def _ordinal(number: int) -> str:
    return f"{number}{dict(enumerate(('st', 'nd', 'rd'), 1)).get(number, 'th')}"
