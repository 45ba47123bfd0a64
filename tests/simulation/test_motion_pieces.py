"""Pieces of the dense output are inside their boxes, and halves are what they are halves of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BPoly

from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.simulation.reference import OdeMotion, reference_motion
from tests.support import OPEN, problem_of


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> OdeMotion:
    """A coin that turns faster and faster."""
    folder: Path = tmp_path_factory.mktemp("pieces")
    problem = problem_of(folder, OPEN, "start.phi_dot=4.0")
    t, u = np.linspace(0.0, 2.0, 11), np.tile([0.3, 0.2], (10, 1))
    found = reference_motion(problem, problem.start, t, u)
    assert isinstance(found, OdeMotion)
    return found


def seen(motion: OdeMotion, pieces: MotionPieces, share: float) -> np.ndarray:
    return motion.along(pieces.knots, pieces.begin + share * (pieces.end - pieces.begin))


@pytest.mark.parametrize("halvings", [0, 1, 4])
def test_what_moves_is_in_its_box_and_is_the_polynomial(motion: OdeMotion, halvings: int) -> None:
    pieces = motion.pieces
    for _ in range(halvings):
        pieces = pieces.halves()
    assert len(pieces.begin) == 2**halvings * len(motion.pieces.begin)
    for share in (1e-9, 0.21, 0.5, 0.83, 1.0):
        x = seen(motion, pieces, share)
        assert ((x >= pieces.box.low) & (x <= pieces.box.high)).all()
        theirs = [BPoly(c[:, None], [0.0, 1.0])(share) for c in pieces.coefficients]
        assert np.array(theirs) == pytest.approx(x, abs=1e-13)


def test_halves_bring_boxes_nearer_by_a_fourth(motion: OdeMotion) -> None:
    """What a box is wider than the motion in it shrinks with the square of its length."""

    def surplus(pieces: MotionPieces) -> float:
        inside = np.array([seen(motion, pieces, s) for s in np.linspace(1e-9, 1.0, 101)])
        return float((pieces.box.width - np.ptp(inside, axis=0)).max())

    pieces = motion.pieces
    before, after = surplus(pieces), surplus(pieces.halves().halves().halves())
    assert after < before / 30
