"""Imports that come late."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from kinolab.errors import InputError
from kinolab.lazy import lazy_package, library_of
from tests.support import environment


@pytest.fixture
def named(tmp_path: Path) -> Callable[[str], Any]:
    """Return what asks a module, which stands for a package, for a name."""
    (tmp_path / "own.py").write_text("from fractions import Fraction as Fraction\n")
    return lazy_package(__name__, str(tmp_path / "own.py"))[1]


def test_a_name_is_imported_when_it_is_asked_for(named: Callable[[str], Any]) -> None:
    assert named("Fraction") is import_module("fractions").Fraction
    assert vars(sys.modules[__name__])["Fraction"] is import_module("fractions").Fraction


def test_an_unknown_name_is_no_attribute(named: Callable[[str], Any]) -> None:
    with pytest.raises(AttributeError, match="has no attribute 'fraction'"):
        named("fraction")


LATE = ("analyze.diagnose", "interchange", "show.view", "show.viewers", "testing", "trajopt")


@pytest.mark.parametrize("facade", ["kinolab", "kinolab.dynamics", *(f"kinolab.{p}" for p in LATE)])
def test_every_name_of_a_lazy_package_has_a_home(facade: str) -> None:
    package = import_module(facade)
    assert package.__all__
    for name in package.__all__:
        assert getattr(package, name) is not None


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError) as caught:
        library_of("hdf5", "h5py", "HDF5 files need h5py")
    text = "hdf5: HDF5 files need h5py, which is not installed. pip install 'kinolab[hdf5]'"
    assert str(caught.value) == text


@pytest.mark.parametrize("facade", ["kinolab", "kinolab.dynamics"])
def test_a_lazy_package_lists_its_names_and_imports_none_of_them(facade: str) -> None:
    """In an interpreter of its own, in which nothing has asked for a name yet."""
    code = f"""
import sys, {facade} as package
assert set(package.__all__) <= set(dir(package)), dir(package)
assert not {{"Any", "TYPE_CHECKING", "lazy_package"}} & set(dir(package)), dir(package)
assert not {{"sympy", "numba", "pydantic", "ompl"}} & set(sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "name",
    [
        *("dynamics", "errors", "gym", "interchange"),
        *("planners", "robots", "systems", "testing"),
    ],
)
def test_a_module_that_is_listed_is_there(name: str) -> None:
    import kinolab

    assert name in dir(kinolab)
    assert getattr(kinolab, name) is import_module(f"kinolab.{name}")
