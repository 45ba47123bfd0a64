"""Why a machine is not flat, as far as there are theorems: each of them is a proof.

Sources: Fliess, Levine, Martin, Rouchon, Flatness and defect of non-linear systems, Int. J. Control
61(6), 1995 (what is not accessible); Charlet, Levine, Marino, On dynamic feedback linearization,
Systems and Control Letters 13, 1989 (one input); Martin, Rouchon, Feedback linearization and
driftless systems, Mathematics of Control, Signals and Systems 7, 1994 (two velocities).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

from kinolab.dynamics.analysis.fields.bracket_filtration import (
    Bracket,
    BracketFiltration,
    bracket,
    work_for,
)
from kinolab.dynamics.analysis.fields.growth_vectors import (
    MAX_WORK,
    filtration,
    rank_of_brackets,
)
from kinolab.dynamics.analysis.fields.involutive import involutive_closure
from kinolab.dynamics.analysis.fields.system_fields import allowed_motions
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.analysis.jets.jets import jet_space
from kinolab.dynamics.analysis.jets.ranks import Rank
from kinolab.errors import InputError

CLEAR = 1e-6  # of a singular value that decides a rank, relative to the largest


def why_not_flat(control: ControlSystem) -> str:
    """Return why a machine is not flat, in a sentence; empty if no theorem says so."""
    fields, disguised, motions = control.fields, 0, 0
    try:
        closure = involutive_closure(control.system)
        disguised, motions = closure.disguised, next(iter(closure.growth), 0)
    except InputError:  # its constraints depend on inputs
        pass
    leaf = replace(fields, dimension=fields.dimension - disguised)
    reached = filtration(leaf, strong=True)
    if reached.complete and not reached.full and _clear(reached.margins[-1:]):
        lost = reached.dimension - reached.rank
        return f"no input affects {lost} of its {reached.dimension} dimensions"
    if len(fields.inputs) == 1:
        return _of_one_input(fields)
    pushed = next(iter(reached.growth), 0)
    affine = not fields.prolonged and not control.system.states
    if affine and motions == 2 == pushed == len(fields.inputs):
        return _of_two_velocities(control, disguised)
    return ""


def _of_two_velocities(control: ControlSystem, disguised: int) -> str:
    """Return why two velocities that inputs decide make no flat machine, if they do not.

    Those of which they do have brackets that span 2, 3, 4, … dimensions at regular configurations.
    """
    motions = allowed_motions(control.system)
    spans = filtration(replace(motions, dimension=motions.dimension - disguised))
    expected = tuple(range(2, 2 + len(spans.growth)))
    if not spans.complete or spans.growth == expected or not _clear(spans.margins):
        return ""
    growth = ", ".join(map(str, spans.growth))
    steps = ", ".join(map(str, expected))
    return (
        f"brackets of its two velocities span ({growth}) dimensions, and those of a flat machine "
        f"({steps}, …) (Martin and Rouchon 1994)"
    )


def _of_one_input(fields: VectorFields) -> str:
    """Return which distribution is not involutive; empty if all are, or work is too long.

    A machine with one input is flat exactly if static feedback linearises it, so that all
    distributions span(g, [f, g], …) are involutive.
    """
    (name,) = fields.inputs
    for k in range(1, fields.dimension - 1):
        chain = work_for(replace(fields, inputs={}), k + 2)  # of brackets, by multiplications
        if work_for(fields, 2) * (k + 1) > MAX_WORK or chain > MAX_WORK:
            return ""
        found = [_involutive(fields, point, k) for point in fields.points]
        if all(involutive is False for involutive in found):
            return (
                f"it has one input ({name}) and static feedback does not linearise it: the "
                f"distribution of the first {k + 1} brackets of its drift with {name} is not "
                "involutive (Charlet, Levine and Marino 1989)"
            )
    return ""


def _involutive(fields: VectorFields, point: Mapping[str, float], k: int) -> bool | None:
    """Return whether span(g, …, ad_f^k g) is involutive at a state; None where that is unclear."""
    layers = BracketFiltration.at(fields, point, k + 2)
    if layers.drift is None:
        return None
    chain, order = [layers.inputs[0]], k + 1
    for _ in range(k):
        order -= 1
        chain.append(_between(layers.drift, chain[-1], len(fields.state), order))
    products = [_between(a, b, len(fields.state), 0) for a, b in combinations(chain, 2)]
    own, both = rank_of_brackets(chain), rank_of_brackets([*chain, *products])
    return both.value == own.value if _clear([own, both]) else None


def _between(f: Bracket, g: Bracket, variables: int, order: int) -> Bracket:
    return bracket(jet_space(variables, order), f, g)


def _clear(ranks: Sequence[Rank]) -> bool:
    return all(rank.smallest > CLEAR for rank in ranks)
