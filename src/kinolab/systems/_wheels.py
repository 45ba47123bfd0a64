"""Shapes of wheels that lean."""

from __future__ import annotations

import math

from kinolab.dynamics import Disk
from kinolab.dynamics.language.shapes import Scalar


def leaning_wheel(radius: Scalar, thickness: Scalar, lean: float) -> tuple[Disk, Disk]:
    """Return a wheel about the y axis that rolls on the middle of its tread and may lean.

    Machines that lean roll on circles without thickness. The visual and collision shape is reduced
    away from the middle so that its edges stay above the ground.

    Args:
        radius: Radius of the rolling circle, in [m].
        thickness: Width of the wheel, in [m].
        lean: Largest angle to the vertical in [rad].
    """
    # 0.2: thickness of the outer disk, relative to the whole
    rim, tread = (
        Disk(radius - across / 2 * math.tan(lean), thickness=across, axis="y")
        for across in (0.2 * thickness, thickness)
    )
    return rim, tread
