"""Work in a process of its own, watched while it runs: a crash ends it, and not the studio."""

from __future__ import annotations

import pickle
import signal
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from kinolab.concurrency.process_worker import WorkerProcess, leave_with
from kinolab.errors import KinolabError

Hear = Callable[[Any], None]


@dataclass(frozen=True)
class Told:
    """What is being done, in words."""

    words: str


@dataclass(frozen=True, eq=False)
class Ended:
    """How work ended; the last message.

    Attributes:
        result: What came of it; None where it failed.
        failure: Why it failed, in words.
    """

    result: Any = None
    failure: str = ""


def work(connection: Connection) -> None:
    """Do a task that comes by a connection, and send its messages, in a process of its own."""
    task, parcel = connection.recv()
    leave_with(connection)
    try:
        connection.send(Ended(task(connection.send, *pickle.loads(parcel))))
    except KinolabError as error:
        connection.send(Ended(failure=str(error)))
    except MemoryError:
        connection.send(Ended(failure="It ran out of memory."))
    except (BrokenPipeError, ConnectionResetError):
        raise
    except Exception:
        connection.send(Ended(failure=traceback.format_exc(limit=-3)))


class BackgroundWork:
    """Work that is running.

    Args:
        task: A function of a module; gets a function that sends messages, and what is given.
        given: Further arguments, as they are now.
        hear: Called with each message in a thread of its own; the last one is ``Ended``.

    Attributes:
        process: In which it runs.
    """

    def __init__(self, task: Callable[..., Any], given: tuple[Any, ...], hear: Hear) -> None:
        self._worker = WorkerProcess(work)
        self.process = self._worker.process
        self._worker.post((task, pickle.dumps(given)))
        self._hear, self._asked = hear, False
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Ask it to end with the best so far; asked again, it ends at once."""
        if self._asked:
            self.process.kill()
        else:
            self.process.terminate()
        self._asked = True

    def close(self) -> None:
        """End it, whatever it does."""
        self._asked = True
        self.process.kill()
        self._thread.join()

    def _listen(self) -> None:
        try:
            while True:
                message = self._worker.connection.recv()
                self._hear(message)
                if isinstance(message, Ended):
                    break
        except (EOFError, OSError):
            self._hear(Ended(failure=self._ending()))
        finally:
            self._worker.end()

    def _ending(self) -> str:
        code = self.process.wait()
        if self._asked:
            return "It was stopped."
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return f"It crashed ({how}). The studio goes on; the scenario is as it was."
