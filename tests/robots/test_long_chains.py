"""Robots whose equations are long: what is said meanwhile, and that they move as Pinocchio says."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinolab.concurrency.stages import heard_by
from kinolab.dynamics.codegen import cache, derived_code
from kinolab.dynamics.codegen.llvm_jit import compile_ir
from kinolab.robots import read_urdf
from tests.support import needs

pytestmark = [needs("yourdfpy"), needs("pinocchio")]

AGREE = 1e-9  # relative to the largest acceleration
LINK = """
<link name="l{i}"><inertial><origin xyz="0.01 0.02 0.1"/><mass value="{mass}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.015" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>
<joint name="j{i}" type="revolute"><parent link="l{before}"/><child link="l{i}"/>
<origin xyz="0 0 0.2" rpy="0.1 0.2 0"/><axis xyz="{axis}"/>
<limit lower="-3" upper="3" effort="100" velocity="5"/></joint>"""
AXES = ("1 0 0", "0 1 0", "0 0 1")


def chain(folder: Path, joints: int) -> Path:
    """A robot of links behind each other, every axis square to the one before."""
    links = (
        LINK.format(i=i, before=i - 1, mass=1 + 0.1 * i, axis=AXES[i % 3])
        for i in range(1, joints + 1)
    )
    file = folder / "chain.urdf"
    file.write_text(f'<robot name="chain"><link name="l0"/>{"".join(links)}</robot>')
    return file


@pytest.fixture
def compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether registers were left out, of each module that is compiled; nothing is kept."""
    seen: list[bool] = []

    def noted(text: str, *, quick: bool = False) -> bytes:
        seen.append(quick)
        return compile_ir(text, quick=quick)

    monkeypatch.setattr(cache, "compile_ir", noted)
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    return seen


@pytest.mark.parametrize("registers", [True, False])
def test_a_robot_moves_as_pinocchio_says_with_registers_and_without(
    registers: bool, compiled: list[bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.robots.against_pinocchio import difference

    monkeypatch.setattr(derived_code, "MOST_IN_REGISTERS", 1e9 if registers else 0)
    file = chain(tmp_path, 4)
    assert difference(file, read_urdf(file), states=5, seed=1) <= AGREE
    assert compiled[0] is not registers


def test_a_long_chain_says_what_is_done_and_moves_as_pinocchio_says(
    compiled: list[bool], tmp_path: Path
) -> None:
    from tests.robots.against_pinocchio import difference

    file, heard = chain(tmp_path, 23), list[str]()
    with heard_by(heard.append):
        assert difference(file, read_urdf(file), states=3, seed=1) <= AGREE
    assert compiled[0]
    assert heard[:2] == ["reading chain.urdf: link l0", "reading chain.urdf: link l1"]
    *_, deriving, compiling = heard
    assert deriving == "deriving the equations of motion of 23 coordinates"
    words = compiling.split()
    assert int(words.pop(-2)) > derived_code.MOST_IN_REGISTERS
    assert " ".join(words) == "compiling equations of motion of operations"
