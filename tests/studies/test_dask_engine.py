"""A Dask cluster makes the same rows; what would spoil them is refused before the first run."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from kinolab.errors import InputError
from kinolab.studies import dask_engine
from kinolab.studies.dask_engine import DaskEngine
from kinolab.studies.problem_files import ProblemFiles
from kinolab.studies.run_study import StudyFolder
from tests.studies.tiny_study import LIMITED, SWINGS, differing, kept, rows_made, study_in

pytest.importorskip("distributed")
psutil = pytest.importorskip("psutil")
files_plugin: Any = pytest.importorskip("kinolab.studies.files_plugin")
pytestmark = pytest.mark.filterwarnings(  # distributed's own, as it leaves
    "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)


def refused(address: str) -> str:
    with pytest.raises(InputError) as caught:
        DaskEngine(address, [])
    return str(caught.value)


@pytest.mark.parametrize(
    "address", ["local:0", "local:x", "local:", "local:-1", "local:²", f"local:{'9' * 5000}"]
)
def test_an_address_that_is_no_cluster_is_refused(address: str) -> None:
    told = refused(address)
    assert told.startswith("--dask: 'local:")
    assert told.endswith("' is no cluster. Write local:8, for 8 workers.")


@pytest.fixture
def server(request: pytest.FixtureRequest) -> Iterator[str]:
    """A port at which nobody says anything, or only what is no Dask."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        answer: bytes = request.param

        def serve() -> None:
            with suppress(OSError):
                while True:
                    connection, _ = listening.accept()
                    connection.sendall(answer)
                    held.append(connection)

        held: list[socket.socket] = []
        threading.Thread(target=serve, daemon=True).start()
        yield f"127.0.0.1:{listening.getsockname()[1]}"
        for connection in held:
            connection.close()


WEB = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n"


@pytest.mark.parametrize("server", [b"", WEB, b"SSH-2.0-x\r\n"], indirect=True)
def test_a_server_of_something_else_is_told(server: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_engine, "CONNECT_SECONDS", 0.3)
    assert refused(f"tcp://{server}").startswith("--dask: no scheduler answers at tcp://127.0.0.1:")


@pytest.mark.parametrize("address", ["foo://127.0.0.1:1", "http://127.0.0.1:1", "inproc://1"])
def test_a_scheme_without_a_scheduler_is_told(address: str) -> None:
    assert refused(address).startswith(f"--dask: no scheduler answers at {address} (")


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_engine, "CONNECT_SECONDS", 0.3)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        told = refused(address)
    assert told.startswith(f"--dask: no scheduler answers at {address} (")
    assert told.endswith("starts one, `dask worker ADDRESS` its workers; or local:8.")


@pytest.mark.parametrize("forged", ["scenario.toml", "assets/machine.json", "assets/evil.py"])
def test_a_worker_replaces_what_its_folder_has_under_a_hash(forged: str, tmp_path: Path) -> None:
    files = ProblemFiles({"scenario.toml": b"schema = 1\n", "assets/machine.json": b"{}"})
    worker: Any = SimpleNamespace(local_directory=str(tmp_path))
    folder = files_plugin.files_root(worker) / files.key
    (folder / "assets").mkdir(parents=True)
    for name, content in {**files.files, forged: b"import os"}.items():
        (folder / name).write_bytes(content)
    files_plugin.FilesPlugin((files,)).setup(worker)
    there = [path for path in folder.rglob("*") if path.is_file()]
    found = {path.relative_to(folder).as_posix(): path.read_bytes() for path in there}
    assert found == files.files


def test_a_cluster_makes_the_rows_of_processes_here(tmp_path: Path) -> None:
    study = study_in(tmp_path, f"{SWINGS}seeds = 4\n{LIMITED}")
    here = rows_made(study, tmp_path / "here")
    folder = StudyFolder(study, tmp_path / "there")
    addresses: list[tuple[str, int]] = []

    def engine(files: Any, _: Path) -> DaskEngine:
        made = DaskEngine("local:2", files)
        addresses.extend(listening())
        return made

    assert folder.run(engine)
    there = [folder.rows[index] for index in sorted(folder.rows)]
    assert differing(here, there) == []
    assert len(kept(tmp_path / "there")) == 4
    assert {host for host, _ in addresses} == {"127.0.0.1"}
    assert len(addresses) >= 5  # of the scheduler, its two workers and what watches these


def listening() -> list[tuple[str, int]]:
    """Addresses at which this process and those that it started wait for others."""
    here = psutil.Process()
    return [
        (entry.laddr.ip, entry.laddr.port)
        for process in (here, *here.children(recursive=True))
        for entry in process.net_connections()
        if entry.status == psutil.CONN_LISTEN
    ]


def test_a_worker_with_another_version_is_refused_before_the_first_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    about: dict[str, Any] = dask_engine.computer()
    versions = {**json.loads(about["versions"]), "numba": "9.9"}
    theirs = json.loads(about["versions"])["numba"]
    other = {**about, "versions": json.dumps(versions)}
    monkeypatch.setattr(dask_engine, "computer", OtherHere(other, dask_engine.computer))
    folder = StudyFolder(study_in(tmp_path, SWINGS), tmp_path / "out")
    with pytest.raises(InputError) as caught:
        folder.run(lambda files, _: DaskEngine("local:1", files))
    told = str(caught.value)
    assert told.startswith("--dask: worker tcp://")
    assert told.endswith(f" has numba {theirs}, not 9.9. Install the same versions there.")
    assert kept(tmp_path / "out") == []


class OtherHere:
    """Says here that a version is another one; where it is sent to, what is true there."""

    def __init__(self, here: dict[str, Any], there: Callable[[], dict[str, Any]]) -> None:
        self._here, self._there = here, there

    def __call__(self) -> dict[str, Any]:
        return self._here

    def __reduce__(self) -> tuple[Any, ...]:
        return getattr, (import_module(self._there.__module__), self._there.__name__)
