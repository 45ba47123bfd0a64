"""Imports that come late."""

from __future__ import annotations

import sys
from importlib import import_module

import pytest

from kinolab.errors import InputError
from kinolab.lazy import lazy_names, library_of


def test_a_name_is_imported_when_it_is_asked_for() -> None:
    named = lazy_names(__name__, {"fractions": ("Fraction",)})
    assert named("Fraction") is import_module("fractions").Fraction
    assert vars(sys.modules[__name__])["Fraction"] is import_module("fractions").Fraction


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'fraction'"):
        lazy_names(__name__, {"fractions": ("Fraction",)})("fraction")


@pytest.mark.parametrize("facade", ["kinolab", "kinolab.dynamics"])
def test_every_name_of_a_lazy_package_has_a_home(facade: str) -> None:
    package = import_module(facade)
    for name in package.__all__:
        assert getattr(package, name) is not None


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError) as caught:
        library_of("plots", "matplotlib", "plots need Matplotlib")
    text = "plots: plots need Matplotlib, which is not installed. pip install 'kinolab[plots]'"
    assert str(caught.value) == text
