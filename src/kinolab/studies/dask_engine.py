"""Orders done by a Dask cluster: one that runs somewhere, or one on this computer.

Files travel by content, once to each worker, also to those that come later (a worker plugin).
"""

from __future__ import annotations

import asyncio
import json
import logging
import re
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, final

from kinolab.errors import InputError, Mistake
from kinolab.lazy import library_of
from kinolab.studies.engine import AbstractEngine, EngineLostError
from kinolab.studies.hardware import computer
from kinolab.studies.problem_files import ProblemFiles

if TYPE_CHECKING:
    from distributed import Client

CONNECT_SECONDS = 4.0  # [s] for a scheduler to answer, and again to take a client
SETTINGS = {  # of Dask, for clusters on this computer: what watches workers takes their processors
    "distributed.scheduler.allowed-failures": 50,  # with one order; the engine counts anew
    "distributed.scheduler.http.routes": ["distributed.http.health"],  # no pages about the study,
    "distributed.worker.http.routes": ["distributed.http.health"],  # which other sites might read
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.system-monitor.gil.enabled": False,
}
WHERE = "--dask"


@final
class DaskEngine(AbstractEngine):
    """The workers of a Dask cluster.

    Args:
        address: Of a scheduler, such as ``tcp://10.0.0.1:8786``, or ``local:8`` for a cluster of 8
            workers on this computer.
        files: What orders need.

    Raises:
        InputError: If Dask is not installed, no scheduler answers, there are no workers, or they
            have other versions than this process.
    """

    def __init__(self, address: str, files: Iterable[ProblemFiles]) -> None:
        self._cluster: Any = None
        self._gone: float | None = None
        try:
            self._client: Client = self._connected(address)
            self.workers = self._checked()
            from kinolab.studies.files_plugin import FilesPlugin, do_order

            self._client.register_plugin(FilesPlugin(tuple(files), self._cluster is not None))
            self.executor, self.work = self._client.get_executor(pure=False), do_order
        except BaseException:
            self.close()
            raise

    def _connected(self, address: str) -> Client:
        distributed = library_of("bench", "distributed", "--dask needs Dask's distributed")
        import dask

        dask.config.set(SETTINGS)
        if address.startswith("local:"):
            count = address.removeprefix("local:")
            if not (re.fullmatch("[0-9]{1,4}", count) and 0 < int(count) <= 1000):
                what = f"{address!r} is no cluster."
                raise InputError([Mistake(WHERE, what, "Write local:8, for 8 workers.")])
            self._cluster = distributed.LocalCluster(
                n_workers=int(count),
                threads_per_worker=1,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # any port that is free
                memory_limit=None,
                silence_logs=logging.CRITICAL,
            )
            address = self._cluster.scheduler_address
        try:
            _require_scheduler(address)  # which a client waits for beyond any limit
            client: Client = distributed.Client(
                address, timeout=CONNECT_SECONDS, set_as_default=False
            )
            return client
        except Exception as error:  # of sockets, Dask, and what other servers answer
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            what = f"no scheduler answers at {address} ({reason})."
            remedy = "`dask scheduler` starts one, `dask worker ADDRESS` its workers; or local:8."
            raise InputError([Mistake(WHERE, what, remedy)]) from None

    def _checked(self) -> int:
        """Return how many threads all workers have.

        Raises:
            InputError: If there are none, or they differ from this process in a version.
        """
        threads: int = sum(self._client.nthreads().values())
        if not threads:
            what, remedy = "the cluster has no workers.", "Start some: `dask worker ADDRESS`."
            raise InputError([Mistake(WHERE, what, remedy)])
        try:
            found = self._client.run(computer)
        except Exception as error:
            what = f"a worker cannot run kinolab ({type(error).__name__}: {error})."
            raise InputError([Mistake(WHERE, what, "Install the same version there.")]) from None
        own = json.loads(computer()["versions"])
        mistakes = []
        for worker, about in found.items():
            theirs = json.loads(about["versions"])
            differing = [
                f"{n} {theirs.get(n)}, not {v}" for n, v in own.items() if theirs.get(n) != v
            ]
            if differing:
                what = f"worker {worker} has {'; '.join(differing)}."
                mistakes.append(Mistake(WHERE, what, "Install the same versions there."))
        if mistakes:
            raise InputError(mistakes)
        return threads

    def require(self) -> None:
        """Make sure that the scheduler is there.

        Raises:
            EngineLostError: If it has been away for a while.
        """
        if self._client.status == "running":
            self._gone = None
            return
        self._gone = self._gone or time.monotonic()
        if time.monotonic() > self._gone + 10.0:  # [s] without a scheduler before it is given up
            raise EngineLostError("Dask's scheduler is gone. What was answered is kept.")

    def lost(self, error: BaseException) -> bool:
        """Whether an order failed only because its worker was lost."""
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        return super().lost(error) or isinstance(error, KilledWorker | FutureCancelledError)

    def close(self) -> None:
        """Leave the cluster; end it if it is this process's own."""
        leaving = threading.Thread(target=self._leave, daemon=True)
        leaving.start()
        # 10 [s] for a cluster to end, 0.2 after Ctrl-C: the rest ends with this process
        leaving.join(0.2 if self.hurried else 10.0)

    def _leave(self) -> None:
        with suppress(Exception):  # a scheduler that is gone need not be left
            self._client.close(timeout=1)
        if self._cluster is not None:
            with suppress(Exception):
                self._cluster.close(timeout=5)


def _require_scheduler(address: str) -> None:
    """Have a scheduler say who it is; in a thread, which is left where that takes too long.

    Raises:
        Exception: Of any kind, if there is none.
    """
    from distributed.core import connect

    async def ask() -> str:
        comm = await connect(address, timeout=CONNECT_SECONDS)
        try:
            await comm.write({"op": "identity", "reply": True})
            return str((await comm.read())["type"])
        finally:
            comm.abort()

    answers: list[str | Exception] = []

    def told() -> None:
        try:
            answers.append(asyncio.run(asyncio.wait_for(ask(), CONNECT_SECONDS)))
        except Exception as error:
            answers.append(error)

    asking = threading.Thread(target=told, daemon=True)
    asking.start()
    asking.join(CONNECT_SECONDS + 1.0)
    answer = answers[0] if answers else TimeoutError("it says nothing")
    if isinstance(answer, Exception):
        raise answer
    if answer != "Scheduler":
        raise ValueError(f"it is a {answer}")
