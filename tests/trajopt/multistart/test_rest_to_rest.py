"""Motions from rest to rest."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.trajopt.multistart.rest_to_rest import profile


@pytest.mark.parametrize("ramp", [0.15, 0.3, 0.5])
def test_a_profile_leads_from_rest_to_rest(ramp: float) -> None:
    """Its derivatives are those of finite differences, and it ends where it should."""
    tau = np.linspace(0.0, 1.0, 4001)
    s, speed, gain = profile(ramp, tau)
    np.testing.assert_allclose([s[0], s[-1], speed[0], speed[-1]], [0, 1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(np.gradient(s, tau)[1:-1], speed[1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(speed, tau)[1:-1], gain[1:-1], atol=0.1)
