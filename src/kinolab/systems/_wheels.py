"""Wheels that lean."""

from __future__ import annotations

import math

from kinolab.dynamics import Disk
from kinolab.dynamics.language.shapes import Scalar

RIM = 0.2  # share of the thickness that the outer of the two disks has


def leaning_wheel(radius: Scalar, thickness: Scalar, lean: float) -> tuple[Disk, Disk]:
    """Return a wheel about the y axis that rolls on the middle of its tread and may lean.

    Machines that lean roll on circles without thickness. What is drawn and may not touch anything
    is as much smaller, the farther from the middle, as keeps its edges above the ground.

    Args:
        radius: Of the circle that rolls, in [m].
        thickness: In [m].
        lean: Largest angle to the vertical in [rad].
    """
    rim, tread = (
        Disk(radius - across / 2 * math.tan(lean), thickness=across, axis="y")
        for across in (RIM * thickness, thickness)
    )
    return rim, tread
