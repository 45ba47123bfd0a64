"""Whatever is in a file, a reader answers with a documented error, soon and in little memory.

The corpus holds sound inputs, and one input for each bug that was found, named after what it shows.
``benchmarks/fuzzing.py`` runs the same targets for hours.
"""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from random import Random

import numpy as np
import pytest

from kinolab import untrusted
from kinolab.errors import InputError
from kinolab.search.graph import read_graph
from kinolab.untrusted import array_file, json_of, nesting
from kinolab.world.meshes import mesh_limits
from tests.fuzz.targets import TARGETS, glb
from tests.support import OPEN, ROOT, environment, within

SLOW = {
    "planning": 2,
    "checked_run": 3,
    "machine": 4,
    "feedback": 4,
    "report": 6,
    "mesh_dae": 10,
    "roadmap": 10,
}  # inputs, of many
COUNT = 20  # inputs of the others
PATIENCE = 60  # [s] for what takes a few, on a busy machine


@pytest.mark.parametrize("name", TARGETS)
def test_every_input_of_the_corpus_is_answered(name: str) -> None:
    for data in TARGETS[name].seeds().values():
        with within(PATIENCE):
            TARGETS[name].run(data)


@pytest.mark.parametrize("name", TARGETS)
def test_damaged_inputs_are_answered(name: str) -> None:
    """The same ones each time: from the seeds, damaged once or several times."""
    target, random = TARGETS[name], Random(name)
    kept = list(target.seeds().values())
    with within(PATIENCE):
        for _ in range(SLOW.get(name, COUNT)):
            data = target.mutate(random.choice(kept), random)
            kept.append(data)
            target.run(data)


# --- limits ---


def refusal(call: Callable[[], object]) -> str:
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)


def archive(shape: str, descr: str, size: int) -> bytes:
    """An NPZ file of one array of zeros, and what its header says of it."""
    head = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        told = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
        file.writestr("x.npy", told + bytes(size))
    return out.getvalue()


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays_are_read_as_numpy_reads_them(save: Callable[..., None], tmp_path: Path) -> None:
    path = tmp_path / "arrays.npz"
    save(
        path, c=np.arange(6.0).reshape(2, 3), f=np.asfortranarray(np.arange(6).reshape(2, 3)),
        text=np.array(["a", "bc"]), one=np.array(1), none=np.zeros((0, 3)),
    )  # fmt: skip
    with np.load(path) as wanted:
        found = array_file(path)
        assert set(found) == set(wanted.files)
        for name, array in found.items():
            assert array.dtype == wanted[name].dtype
            np.testing.assert_array_equal(array, wanted[name])


def test_arrays_are_refused_before_they_are_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "arrays.npz"
    path.write_bytes(archive("(10000000000,)", "<f8", 8))
    with pytest.raises(ValueError, match=r"x.npy is not as large as it says"):
        array_file(path)
    monkeypatch.setitem(untrusted.BYTES, "arrays", 1_000_000)
    path.write_bytes(archive("(250000,)", "<f8", 2_000_000))
    assert path.stat().st_size < 10_000
    with pytest.raises(ValueError, match="its arrays take more than 1 MB"):
        array_file(path)


@pytest.mark.parametrize("order", "<>")
def test_numbers_that_are_no_characters_are_no_text(order: str, tmp_path: Path) -> None:
    """NumPy takes them for text, and Python ends with a SystemError."""
    path = tmp_path / "search.npz"
    last, beyond = (
        np.array([code], f"{order}u4").view(f"{order}U1") for code in (0x10FFFF, 0x110000)
    )
    np.savez(path, state_names=last)
    assert array_file(path)["state_names"].tolist() == ["\U0010ffff"]
    np.savez(path, x=np.zeros((1, 1)), edges=np.zeros((0, 2), np.int32), state_names=beyond)
    with pytest.raises(ValueError, match=r"state_names.npy is no text"):
        array_file(path)
    with pytest.raises(InputError, match="it is damaged"):
        read_graph(path, ["x"])


def test_an_archive_of_very_many_entries_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arrays.npz"
    with zipfile.ZipFile(path, "w") as file:
        for number in range(2000):
            file.writestr(f"{number}.npy", b"")
    with pytest.raises(ValueError, match="too many entries"):
        array_file(path)


def test_json_is_refused_where_it_is_nested_too_deeply() -> None:
    most = untrusted.ELEMENTS["levels of lists and tables"]
    assert nesting(b'{"a[[[": [1, {"b\\"{{": []}]}') == 4
    assert json_of("[" * most + "]" * most)
    with pytest.raises(ValueError, match="nested too deeply"):
        json_of("[" * (most + 1) + "]" * (most + 1))


def test_a_glb_may_not_ask_for_zeros_that_it_does_not_hold() -> None:
    """One kilobyte of JSON: a thousand arrays of a million matrices are 64 GB."""
    empty = {"componentType": 5126, "count": 1_000_000, "type": "MAT4"}
    content = glb(json.dumps({"accessors": [empty] * 1000}).encode(), b"")
    assert "64000 MB of zeros" in refusal(lambda: mesh_limits.require_size("m", "glb", content))


def test_meshes_of_text_are_smaller_than_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(untrusted.BYTES, "mesh in ply", 1000)
    head = b"ply\nformat %s 1.0\nend_header\n"
    mesh_limits.require_size("m", "ply", head % b"binary_little_endian" + bytes(2000))
    text = head % b"ascii" + b"0 0 0\n" * 300
    assert "is larger than" in refusal(lambda: mesh_limits.require_size("m", "ply", text))


def test_an_stl_of_very_many_solids_is_refused() -> None:
    content = b"solid a\nendsolid a\n" * (untrusted.ELEMENTS["solids"] + 1)
    assert "1000 solids" in refusal(lambda: mesh_limits.require_size("m", "stl", content))


@pytest.mark.parametrize(
    ("nodes", "what"),
    [
        ([{"children": [k + 1]} for k in range(101)] + [{}], "more than 100 levels of nodes"),
        ([{"children": [0]}], "more than 100 levels of nodes"),
        ([{}] * (untrusted.ELEMENTS["nodes"] + 1), "more than 20000 nodes"),
    ],
)
def test_a_glb_of_many_nodes_or_deep_ones_is_refused(nodes: list[object], what: str) -> None:
    content = glb(json.dumps({"nodes": nodes}).encode(), b"")
    assert what in refusal(lambda: mesh_limits.require_size("m", "glb", content))


def test_nodes_of_a_dae_are_counted_as_often_as_they_are_used() -> None:
    def folded(levels: int) -> bytes:
        twice = '<node id="n{}"><instance_node url="#n{}"/><instance_node url="#n{}"/></node>'
        nodes = "".join(twice.format(k + 1, k, k) for k in range(levels))
        return f'<a xmlns="b"><node id="n0"><node/></node>{nodes}</a>'.encode()

    # Each of the first three stands by itself, too: 2, then 2 (2) + 1 = 5, then 2 (5) + 1 = 11.
    assert mesh_limits.unfolded_nodes(folded(2)) == 2 + 5 + 11
    assert mesh_limits.unfolded_nodes(folded(40)) > untrusted.ELEMENTS["nodes"]
    itself = b'<a><node id="n"><instance_node url="#n"/></node></a>'
    assert mesh_limits.unfolded_nodes(itself) > untrusted.ELEMENTS["nodes"]


def test_an_obj_of_very_many_materials_is_refused() -> None:
    most = untrusted.ELEMENTS["materials"]
    mesh_limits.require_size("m", "obj", b"usemtl a\n" * (most + 1))
    many = b"".join(b"usemtl %d\n" % k for k in range(most + 1))
    assert "2000 materials" in refusal(lambda: mesh_limits.require_size("m", "obj", many))


def test_a_scenario_of_very_many_values_is_refused(tmp_path: Path) -> None:
    from kinolab.scenario import load_scenario

    path = tmp_path / "table.toml"
    path.write_text(OPEN + "[x]\na = [" + "{}," * (untrusted.ELEMENTS["values"] + 1) + "]\n")
    assert f"more than {untrusted.ELEMENTS['values']} values" in refusal(
        lambda: load_scenario(path)
    )


# --- the worst contents of the largest sizes ---

WORST: dict[str, tuple[str, Callable[[], bytes]]] = {
    "report": ("report", lambda: b'{"a":[' + b"{}," * 6_600_000 + b"{}]}"),
    "table": (
        "trajectory_csv",
        lambda: (
            b"t,x,y,psi,phi,psi_dot,phi_dot,drive,steer\n"
            + b"10,11,12,13,14,15,16,17,18\n" * 1_800_000
        ),
    ),
    "inputs": ("inputs_csv", lambda: b"t,drive,steer\n" + b"10,11,12\n" * 5_500_000),
    "arrays": ("search_npz", lambda: archive("(8300000, 6)", "<f8", 8_300_000 * 48)),
    "scenario": ("scenario", lambda: OPEN.encode() + b"[x]\na = [" + b"{}," * 330_000 + b"]"),
    "environment": ("dynobench", lambda: b"[" + b"1," * 149_000 + b"]"),
    "problem": ("omplapp", lambda: b"[problem]\n" + b"a=\n" * 9_999),
    "machine": ("machine", lambda: b"[" + b"{}," * 660_000 + b"{}]"),
    "study": ("study", lambda: b"a = [" + b"{}," * 330_000 + b"]"),
    "row": ("journal", lambda: b"[" + b"{}," * 333_000 + b"{}]\n"),
}
MEASURE = """
import resource, sys
from pathlib import Path
from tests.fuzz.targets import TARGETS
target, data = TARGETS[sys.argv[1]], Path(sys.argv[2]).read_bytes()
for seed in target.seeds().values():
    target.run(seed)
pages = int(Path("/proc/self/statm").read_text().split()[0])
most = pages * resource.getpagesize() + int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_AS, (most, most))
target.run(data)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited by Linux")
@pytest.mark.parametrize("name", WORST)
def test_the_worst_content_of_the_largest_size_stays_below_the_cap(
    name: str, tmp_path: Path
) -> None:
    """A process that may take no more memory than the cap reads it, and does not run out of it."""
    target, make = WORST[name]
    path = tmp_path / "content"
    path.write_bytes(make())
    subprocess.run(
        [sys.executable, "-c", MEASURE, target, str(path), str(untrusted.MEMORY)],
        env=environment(), cwd=ROOT, check=True, timeout=600,
    )  # fmt: skip
