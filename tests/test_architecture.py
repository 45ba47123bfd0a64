"""What holds the house together: packages, data files, generated files."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from runpy import run_path
from typing import Any

import pytest

from kinolab.scenario.values import MESH_FORMATS
from tests.support import ROOT, environment

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SETUPTOOLS = PROJECT["tool"]["setuptools"]
MESHES = ROOT / "scenarios" / "meshes"


def folder_of(package: str) -> Path:
    places: dict[str, str] = SETUPTOOLS["package-dir"]
    return ROOT / places.get(package, f"{places['']}/{package.replace('.', '/')}")


def packages_on_disk() -> set[str]:
    found = {"kinolab.planners", "kinolab.scenarios"}
    for folder, _, files in os.walk(ROOT / "src" / "kinolab"):
        if "__init__.py" in files:
            found.add(".".join(Path(folder).relative_to(ROOT / "src").parts))
    return found


def test_every_package_is_listed() -> None:
    assert set(SETUPTOOLS["packages"]) == packages_on_disk()


def test_every_folder_of_code_is_a_package() -> None:
    for folder, _, files in os.walk(ROOT / "src" / "kinolab"):
        if any(file.endswith(".py") for file in files):
            assert "__init__.py" in files, folder


@pytest.mark.parametrize("package", SETUPTOOLS["packages"])
def test_every_file_of_a_package_that_is_not_code_is_shipped(package: str) -> None:
    patterns = SETUPTOOLS["package-data"].get(package, [])
    folder = folder_of(package)
    assert (folder / "__init__.py").is_file()
    for file in folder.iterdir():
        if file.is_file() and file.suffix not in {".py", ".pyc"}:
            assert any(fnmatch(file.name, pattern) for pattern in patterns), file


def test_the_meshes_of_scenarios_are_shipped() -> None:
    shipped = SETUPTOOLS["package-data"]["kinolab.scenarios"]
    for mesh in MESHES.iterdir():
        wanted = mesh.suffix in MESH_FORMATS
        assert any(fnmatch(f"meshes/{mesh.name}", pattern) for pattern in shipped) == wanted


def test_every_mesh_is_what_its_script_writes(tmp_path: Path) -> None:
    makers = run_path(str(ROOT / "tools" / "meshes" / "write_meshes.py"))["MESHES"]
    assert {file.name for file in MESHES.iterdir() if file.suffix not in {".py", ""}} == set(makers)
    for name, make in makers.items():
        make().export(tmp_path / name)
        written, stored = ((folder / name).read_bytes() for folder in (tmp_path, MESHES))
        assert written[80:] == stored[80:]  # an STL file begins with 80 bytes of remarks


def test_every_mesh_of_a_scenario_is_used() -> None:
    scenarios = "".join(path.read_text() for path in (ROOT / "scenarios").glob("*.toml"))
    for mesh in MESHES.glob("*.stl"):
        assert f'"meshes/{mesh.name}"' in scenarios


def test_planners_imported_from_the_root_are_refused() -> None:
    """They would be the same classes under a second identity."""
    path = os.pathsep.join([str(ROOT), environment()["PYTHONPATH"]])
    done = subprocess.run(
        [sys.executable, "-c", "import planners"],
        cwd=ROOT,
        env=environment() | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "ImportError: Import this package as kinolab.planners" in done.stderr


def test_importing_kinolab_is_light() -> None:
    code = "import sys, kinolab; print(*sorted({'numpy', 'sympy', 'trimesh'} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == []


def test_the_console_script_is_the_command_line() -> None:
    from kinolab import cli

    module, _, function = PROJECT["project"]["scripts"]["plan"].partition(":")
    assert module == cli.__name__
    assert callable(getattr(cli, function))
