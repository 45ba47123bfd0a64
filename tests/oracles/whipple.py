"""What has been published about the benchmark bicycle. SI units throughout.

The source's axes point ahead, to the right and down: a lean counts to the right, as in kinolab, and
steering to the right, which counts as negative in kinolab.

Sources:
    Meijaard, Papadopoulos, Ruina, Schwab, Linearized dynamics equations for the balance and steer
        of a bicycle: a benchmark and review, Proc. R. Soc. A 463, 2007: the matrices of
        M q_ddot + v C1 q_dot + (g K0 + v^2 K2) q = f with q = (lean, steer), and table 2.
    Basu-Mandal, Chatterjee, Papadopoulos, Hands-free circular motions of a benchmark bicycle,
        Proc. R. Soc. A 463, 2007, table 1: accelerations at one state far from straight riding.
    SymPy 1.14, physics/mechanics/tests/test_kane3.py: the linearisation by Kane's method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

G = 9.81
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])

WEAVE, CAPSIZE = 4.292382536341110, 6.024262015388370  # [m/s] between which it rides by itself

# Eigenvalues in [1/s] by speed in [m/s].
EIGENVALUES = {
    0.0: (-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393),
    5.0: (
        -14.07838969279822,
        -0.77534188219585 - 4.46486771378823j,
        -0.77534188219585 + 4.46486771378823j,
        -0.32286642900409,
    ),
}


def state_matrix(v: float) -> Array:
    """Return A of (lean, steer, lean rate, steer rate) at a speed in [m/s], shape (4, 4)."""
    stiff, damped = np.linalg.solve(M, G * K0 + v**2 * K2), np.linalg.solve(M, v * C1)
    return np.block([[np.zeros((2, 2)), np.eye(2)], [-stiff, -damped]])


def kane_matrix(v: float) -> Array:
    """Return the lower half of the same matrix as SymPy's test has it, shape (2, 4)."""
    roll = [
        *(9.48977444677355, -0.891197738059089 * v**2 - 0.571523173729245),
        *(-0.105522449805691 * v, -0.330515398992311 * v),
    ]
    steer = [
        *(11.7194768719633, -1.97171508499972 * v**2 + 30.9087533932407),
        *(3.67680523332152 * v, -3.08486552743311 * v),
    ]
    return np.array([roll, steer])


# One state and its accelerations. The source's angles are theta = heading, psi = pi / 2 - lean and
# phi = pi + pitch, with the nose down; here steering to the left is positive, as in kinolab. The
# wheels turn against the frame and the fork.
TURNED = {"lean": np.pi / 2 - 0.9501292851472, "pitch": 3.1257073014894 - np.pi}
TURNED["steer"] = 0.2311385135743
RATES = {
    "heading": 0.7830033527065,
    "lean": -0.6068425835418,
    "pitch": -0.0119185528069,
    "steer": 0.4859824687093,
    "rear": 8.9129896614890,
    "front": 8.0133620584155,
}
ACCELERATIONS = {
    "heading": 0.8353281706379,
    "lean": 7.8555281128244,
    "pitch": 0.1205543897884,
    "steer": -4.6198904039403,
    "rear": 1.8472554144217,
    "front": 2.4548072904550,
}
