"""Heun's method: a predictor by Euler's step, and the mean of the slopes at both ends.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.1, table 1.1.
"""

from __future__ import annotations

from kinolab.dynamics.codegen.methods import Method

HEUN = Method("heun", order=2, a=((), (1.0,)), b=(0.5, 0.5))
