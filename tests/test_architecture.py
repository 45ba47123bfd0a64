"""What holds the house together: arrows, names and sizes, packages, data and generated files."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

import pytest

from kinolab.dynamics.language.forces import FORCES
from kinolab.dynamics.language.inputs import INPUTS
from kinolab.dynamics.language.shapes import SHAPES
from kinolab.scenario.values import MESH_FORMATS
from tests.support import ROOT, environment

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SETUPTOOLS = PROJECT["tool"]["setuptools"]
MESHES = ROOT / "scenarios" / "meshes"
CODE = {ROOT / "src" / "kinolab": "kinolab", ROOT / "planners": "kinolab.planners"}

ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PLACES = re.compile(r"`([\w./*-]*(?:/[\w.*-]*|\.py))`")
ATTITUDE = {"Attitude", "QuaternionEntry", "TurnRate", "TurnAcceleration"}
MOST_KNOW_ATTITUDES = 17  # files, most of them of symbols; 83 when each sliced its quaternions

FAMILIAR = {"__init__", "data"}  # files that are read with the name of their folder
MAX_MODULES = 16  # of a folder, beside its subfolders
FILE_PER_MACHINE = {"systems", "planners"}  # they are looked up by name, however many
MAX_LOOSE_MODULES = 8
WRAPS = re.compile(  # an angle divided by a turn, or its remainder
    r"(%|/|\b(mod|fmod|remainder)\().{0,40}(2(\.0)?\s*\*\s*(np|math)\.pi|\btau\b|\bTURN\b)"
    r"|(arctan2|atan2)\((np\.|math\.)?sin\("
)


def folder_of(package: str) -> Path:
    places: dict[str, str] = SETUPTOOLS["package-dir"]
    return ROOT / places.get(package, f"{places['']}/{package.replace('.', '/')}")


def packages_on_disk() -> set[str]:
    found = {"kinolab.planners", "kinolab.scenarios"}
    for folder, _, files in os.walk(ROOT / "src" / "kinolab"):
        if "__init__.py" in files:
            found.add(".".join(Path(folder).relative_to(ROOT / "src").parts))
    return found


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """Return all nodes of a file's syntax tree, which several tests go through."""
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def modules() -> dict[str, Path]:
    """Return every file of code by the name that it is imported by."""
    found = {}
    for folder, package in CODE.items():
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


def imports_of(path: Path, known: dict[str, Path]) -> Iterator[str]:
    """Yield the modules that a file imports anywhere, in functions and for types, too."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports from where it lies; write the whole name"
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield from [name for name in (inner, str(node.module)) if name in known][:1]


def test_no_import_comes_back_to_where_it_began() -> None:
    """Imports inside of functions and those for types count: they say what rests on what."""
    known = modules()
    arrows = {name: {*imports_of(path, known)} - {name} for name, path in known.items()}
    TopologicalSorter(arrows).prepare()  # names a circle, where there is one


def test_no_folder_and_one_below_it_import_each_other() -> None:
    """What both need is in a third; the package itself, with its loose modules, is left out."""
    known = modules()
    homes = {n: n if p.stem == "__init__" else n.rpartition(".")[0] for n, p in known.items()}
    arrows = {(homes[a], homes[b]) for a, path in known.items() for b in imports_of(path, known)}
    entwined = {(a, b) for a, b in arrows if b.startswith(f"{a}.") and (b, a) in arrows}
    assert {(a, b) for a, b in entwined if a != "kinolab"} == set()


def test_no_name_of_a_file_or_of_a_class_stands_twice() -> None:
    paths = modules().values()
    files = Counter(path.stem for path in paths if path.stem not in FAMILIAR)
    nodes = (node for path in paths for node in nodes_of(path))
    classes = Counter(node.name for node in nodes if isinstance(node, ast.ClassDef))
    assert [name for name, count in (files + classes).items() if count > 1] == []


def test_angles_are_wrapped_in_one_file() -> None:
    wrapping = {path.name for path in modules().values() if WRAPS.search(path.read_text("utf-8"))}
    assert wrapping == {"state_space.py"}


def test_fcl_is_called_in_one_file() -> None:
    callers = {
        path.name
        for path in modules().values()
        for node in nodes_of(path)
        if isinstance(node, ast.Import) and node.names[0].name == "fcl"
    }
    assert callers == {"fcl.py"}


def test_no_folder_is_longer_than_a_glance() -> None:
    sizes = Counter(path.parent for path in modules().values() if path.stem != "__init__")
    long = {folder.name: size for folder, size in sizes.items() if size > MAX_MODULES}
    assert long.keys() <= FILE_PER_MACHINE, long


def test_few_modules_lie_loose() -> None:
    loose = {path.stem for path in (ROOT / "src" / "kinolab").glob("*.py")} - FAMILIAR
    assert len(loose) <= MAX_LOOSE_MODULES, loose


def test_every_place_that_the_architecture_names_is_there() -> None:
    named = {place for place in PLACES.findall(ARCHITECTURE) if "NAME" not in place}
    homes = (ROOT / "src" / "kinolab", ROOT)
    absent = {place for place in named if not any([*home.glob(place)] for home in homes)}
    assert absent == set()
    assert len(named) > 50


def architecture_row(thing: str) -> tuple[str, set[str]]:
    """Return what to touch to add a thing, in words, and the files of code among it."""
    (row,) = re.findall(rf"^\| {thing}[^|]*\| (.*) \|$", ARCHITECTURE, re.MULTILINE)
    places = {place for place in PLACES.findall(row) if place.endswith(".py")}
    return row, places


@cache
def words_of(path: Path) -> frozenset[str]:
    """Return the names that a file of code uses, comments and texts left out."""
    nodes = nodes_of(path)
    found = {node.id for node in nodes if isinstance(node, ast.Name)}
    found |= {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    found |= {node.name for node in nodes if isinstance(node, ast.alias | ast.ClassDef)}
    return frozenset(found)


def files_that_name(words: set[str], at_least: int = 1) -> set[str]:
    """Return the files of the package, apart from its machines, that use so many of the words."""
    package = ROOT / "src" / "kinolab"
    return {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if "systems" not in path.parts and len(words & words_of(path)) >= at_least
    }


@pytest.mark.parametrize(
    ("thing", "kinds"),
    [
        ("a kind of force", {"Viscous", "Coulomb", "Spring", "Rope", "Wrench", "Buoyancy"}),
        ("a kind of input", {"Torque", "Force", "Pull", "Rate", "Drive", "Control"}),
    ],
)
def test_a_new_force_or_input_touches_the_files_that_the_architecture_names(
    thing: str, kinds: set[str]
) -> None:
    row, places = architecture_row(thing)
    assert places == files_that_name(kinds, at_least=2)
    assert row.startswith(f"{len(places)} files ")


@pytest.mark.parametrize("words", [FORCES, INPUTS, SHAPES])
def test_nothing_outside_the_language_asks_of_which_kind_a_word_is(
    words: tuple[type, ...],
) -> None:
    """Each owns its laws; a chain of questions would be one more place for a new one."""
    names = {kind.__name__ for word in words for kind in word.__mro__[:-1]} - {"Shape"}
    inside = {"language", "symbols"}  # the words, and what all words are
    outside = (path for path in modules().values() if not inside & {*path.parts})
    assert {path.name for path in outside if names & asked_of(path)} == set()


def asked_of(path: Path) -> set[str]:
    """Return the classes that a file of code compares things with, by isinstance or in a match."""
    kinds = [node.cls for node in nodes_of(path) if isinstance(node, ast.MatchClass)]
    for node in nodes_of(path):
        asks = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if asks and node.func.id in ("isinstance", "issubclass"):
            kinds.append(node.args[1])
    named = [part for kind in kinds for part in ast.walk(kind)]
    return {part.id for part in named if isinstance(part, ast.Name)}


def test_few_files_know_an_attitude_from_other_coordinates() -> None:
    """What is done with a state asks its parts, which have their own laws."""
    concerned = files_that_name(ATTITUDE)
    row, _ = architecture_row("a topology")
    assert len(concerned) <= MOST_KNOW_ATTITUDES
    assert f" {len(concerned)} files " in row
    sliced = {
        path.name
        for path in (ROOT / "src" / "kinolab").rglob("*.py")
        for node in nodes_of(path)
        if isinstance(node, ast.Attribute) and node.attr in {"attitudes", "quaternions"}
    }
    assert len(sliced) <= 1  # a number of headings that are tried


def test_constants_of_modules_are_few() -> None:
    """What one place uses stands there; caps of files are in one table of ``untrusted``."""
    code = "\n".join(path.read_text(encoding="utf-8") for path in modules().values())
    assert len(re.findall(r"^[A-Z][A-Z_]+ = ", code, re.MULTILINE)) < 1030
    assert len(re.findall(r"^(?:MOST|MAX)_[A-Z_]+ = ", code, re.MULTILINE)) < 40


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
