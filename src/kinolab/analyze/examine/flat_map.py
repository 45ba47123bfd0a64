"""A flat map that does not hold along the machine's own motions."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.analysis.flat.given_map import wrong_map


def flat_map(subject: Subject) -> Iterator[Remark]:
    """Yield the coordinate that a machine's flat map gets wrong; planners would steer by it."""
    system = subject.system
    if system.flat is None:
        return
    wrong = wrong_map(ControlSystem.of(system, subject.model))
    if wrong is not None:
        what = wrong.sentence
        sentence = f"{what[0].upper()}{what[1:]} It must hold along every motion without friction."
        kind = type(system.flat).__name__
        yield Remark("flat map that does not hold", wrong.coordinate, sentence, (kind, ""))
