"""Compiled machines on disk: shared, rebuilt where damaged, never needed."""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab.systems
from kinolab.dynamics import Model, System
from kinolab.dynamics.codegen import cache, derived_code
from kinolab.dynamics.codegen.cache import COMPILED
from kinolab.dynamics.codegen.llvm_jit import compile_ir
from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.store import folder
from tests.machines import finned_hull

STATE = [0.4, -0.7]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the machines that are derived while a test runs."""
    seen: list[str] = []

    def counted(system: System) -> Any:
        seen.append(system.name)
        return derive(system)

    monkeypatch.setattr(derived_code, "derive", counted)
    return seen


def motion() -> bytes:
    f = kinolab.systems.get("pendulum").model().f(STATE, [0.3])
    return f.tobytes()


def test_the_variable_names_the_folder(home: Path) -> None:
    assert folder() == home


def test_a_machine_is_derived_once(home: Path, builds: list[str]) -> None:
    made = [motion() for _ in range(3)]
    assert builds == ["pendulum"]
    assert made[1] == made[2] == made[0]
    (entry,) = home.glob("*.machine")
    assert entry.read_bytes().startswith(COMPILED.magic)


def test_another_value_of_a_parameter_is_another_entry_but_the_same_motion(home: Path) -> None:
    """The values of a machine are part of its text; nothing of one may reach the other."""
    base = kinolab.systems.get("pendulum").model()
    heavy = kinolab.systems.get("pendulum", m=3.0).model()
    np.testing.assert_array_equal(heavy.f(STATE, [0.3]), base.f(STATE, [0.3], m=3.0))
    assert not np.array_equal(heavy.f(STATE, [0.3]), base.f(STATE, [0.3]))
    assert list(home.iterdir())


@pytest.mark.usefixtures("home")
def test_another_value_of_a_parameter_compiles_and_loads_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """LLVM keeps some memory of all that it compiles, and of what it loads."""
    compiled: list[str] = []

    def counted(text: str, *, quick: bool) -> bytes:
        compiled.append(text)
        return compile_ir(text, quick=quick)

    monkeypatch.setattr(cache, "compile_ir", counted)
    models = [kinolab.systems.get("pendulum", m=m).model() for m in (1.0, 2.0, 3.0)]
    assert len(compiled) == 1
    assert len({model.address("f") for model in models}) == 1


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "without its last byte": lambda content: content[:-1],
    "with one byte changed in the code": lambda content: content[:-9] + b"!" + content[-8:],
    "with one byte changed in the facts": lambda content: content.replace(b"sizes", b"sizez"),
    "only its beginning": lambda _: COMPILED.magic,
    "of another format": lambda content: b"kinolab object 0\n" + content[len(COMPILED.magic) :],
    "text": lambda _: b"not a machine at all",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_built_anew(home: Path, builds: list[str], damage: str) -> None:
    expected = motion()
    (entry,) = home.glob("*.machine")
    whole = entry.read_bytes()
    entry.write_bytes(DAMAGES[damage](whole))
    assert motion() == expected
    assert builds == ["pendulum"] * 2
    assert motion() == expected
    assert len(builds) == 2, "it was not repaired"


def test_an_entry_that_is_a_folder_is_no_error(home: Path) -> None:
    expected = motion()
    (entry,) = home.glob("*.machine")
    entry.unlink()
    entry.mkdir()
    assert motion() == expected
    assert [path for path in home.iterdir() if path.name.startswith(".")] == [], (
        "a draft was left behind"
    )


def test_a_folder_that_cannot_be_written_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file where a folder should be refuses everyone, root too."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "file" / "cache"))
    first = motion()
    assert motion() == first
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.usefixtures("home")
def test_a_full_disk_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    first = motion()
    assert motion() == first


CHILD = """
import sys
from kinolab.dynamics.model import model
import kinolab.systems
def refuse(system): raise AssertionError("it was derived again")
model.derive = refuse
f = kinolab.systems.get("pendulum").model().f([0.4, -0.7], [0.3])
sys.stdout.buffer.write(f.tobytes())
"""


def test_a_second_process_gets_it(home: Path) -> None:
    expected = motion()
    source = str(Path(str(kinolab.__file__)).resolve().parents[1])
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        env={**os.environ, "PYTHONPATH": source, "KINOLAB_CACHE": str(home)},
        capture_output=True,
        check=True,
    )
    assert done.stdout == expected


def work(text: str, pickled: bytes, x: list[float], u: list[float]) -> list[bytes]:
    """What a worker does: the same machine from JSON and from a pickle."""
    systems = (machine_from_json(text), pickle.loads(pickled))
    return [Model(system).step(x, u, 0.01).tobytes() for system in systems]


@pytest.mark.usefixtures("home")
def test_a_spawned_worker_gets_a_machine_as_json_and_as_a_pickle() -> None:
    """Spawn shares nothing with its parent: no symbols, no serial numbers, no code."""
    system = finned_hull()
    x, u = [0.1, 0.2, 0.3, 0.0, 0.6, 0.0, 0.8, *[0.2] * 6], [1.0, 0.1, -0.1]
    with get_context("spawn").Pool(1) as pool:
        made = pool.apply(work, (machine_to_json(system), pickle.dumps(system), x, u))
    assert made == [system.model().step(x, u, 0.01).tobytes()] * 2
