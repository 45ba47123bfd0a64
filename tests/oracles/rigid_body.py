"""The free asymmetric top in closed form: Euler's equations solved by Jacobi's elliptic functions.

Source: Landau, Lifshitz, Mechanics, 3rd ed., 1976, section 37.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipj, ellipk

Array: TypeAlias = NDArray[np.float64]


class Top:
    """A top whose rate goes round the axis of its largest moment: H^2 > 2 T I2.

    Args:
        moments: I1 < I2 < I3, shape (3,), in [kg m^2], about axes that make a right-handed frame.
        first: Rates (w1, 0, w3) at time zero, shape (3,), in [rad/s], w1 and w3 positive.
    """

    def __init__(self, moments: Array, first: Array) -> None:
        I1, I2, I3 = moments
        twice_T, square_H = float(moments @ first**2), float((moments * first) @ (moments * first))
        if not square_H > twice_T * I2:
            raise ValueError("the motion goes round the first axis")
        short, long = twice_T * I3 - square_H, square_H - twice_T * I1
        self.amplitudes = np.sqrt(
            [short / (I1 * (I3 - I1)), short / (I2 * (I3 - I2)), long / (I3 * (I3 - I1))]
        )
        self.pace = float(np.sqrt((I3 - I2) * long / (I1 * I2 * I3)))  # of the argument, in [1/s]
        self.parameter = float((I2 - I1) * short / ((I3 - I2) * long))  # k^2

    @property
    def period(self) -> float:
        """Time in [s] after which the rates repeat."""
        return float(4 * ellipk(self.parameter) / self.pace)

    def rates(self, t: Array) -> Array:
        """Rates about the axes at times t, shape (n, 3)."""
        sn, cn, dn, _ = ellipj(self.pace * np.asarray(t), self.parameter)
        return self.amplitudes * np.stack([cn, sn, dn], axis=-1)


def polhode_frequency(transverse: float, axial: float, spin: float) -> float:
    """Rate in [rad/s] at which the rate's vector goes round the axis of a symmetric top."""
    return (axial - transverse) / transverse * spin
