"""Equations that no compiler could take are refused with the limit."""

from __future__ import annotations

import pytest

from kinolab import systems
from kinolab.dynamics.codegen import derived_code
from kinolab.errors import InputError


@pytest.mark.parametrize("name", ["crane", "acrobot_v0"])
def test_too_many_operations_are_refused_before_they_are_compiled(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(derived_code, "MOST_OPERATIONS", 10)
    with pytest.raises(InputError, match=r"take \d+ operations; 10 are the most that are compiled"):
        derived_code.derived_code(systems.get(name), None)
