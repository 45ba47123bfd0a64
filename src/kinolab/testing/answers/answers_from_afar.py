"""Answers that are judged in another process than the one that gave them: only data travel.

The notebook's process sends a value, the text of a machine, or a name for a function, and is asked
for what the function returns; the grader's process judges, and keeps the mark.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Client, Connection, Listener
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from kinolab.dynamics import System
from kinolab.errors import LONGEST_QUOTE
from kinolab.untrusted import BYTES, json_of


class _Unreadable:
    """Stands for a value that is no data; it has only its text."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


class _Peer:
    """One end of a connection: encodes values, and calls functions of the other end."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._own: list[Callable[..., Any]] = []

    def send(self, **message: Any) -> None:
        """Send a message."""
        self._connection.send_bytes(json.dumps(message).encode())

    def receive(self) -> dict[str, Any]:
        """Return the next message that is no call; calls are answered meanwhile.

        Raises:
            EOFError: If the other end is gone.
            ValueError: If it sends what is no message.
        """
        while True:
            message = json_of(self._connection.recv_bytes(BYTES["json"]))
            if not isinstance(message, dict):
                raise ValueError("it is no message")
            if "call" not in message:
                return message
            try:
                function = self._own[int(message["call"])]
                value = self.encoded(function(*map(self.decoded, message["arguments"])))
            except Exception as error:  # whatever somebody's function raises
                self.send(error=[type(error).__name__, str(error)])
            else:
                self.send(value=value)

    def _called(self, number: int, arguments: tuple[Any, ...]) -> Any:
        self.send(call=number, arguments=[*map(self.encoded, arguments)])
        message = self.receive()
        if "error" in message:
            kind, text = message["error"]
            raise type(str(kind), (Exception,), {})(str(text))
        return self.decoded(message["value"])

    def encoded(self, value: Any) -> Any:
        """Return a value as JSON has it."""
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, list | tuple):
            kind = "list" if isinstance(value, list) else "tuple"
            return {kind: [*map(self.encoded, value)]}
        if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
            return {"array": value.tolist(), "kind": value.dtype.kind, "shape": value.shape}
        if isinstance(value, dict):
            return {"dict": [[self.encoded(key), self.encoded(v)] for key, v in value.items()]}
        if value is ...:
            return {"dots": True}
        if isinstance(value, System):
            from kinolab.dynamics.language.json.machine_file import machine_to_json

            return {"machine": machine_to_json(value)}
        if callable(value):
            self._own.append(value)
            return {"function": len(self._own) - 1}
        with suppress(TypeError, ValueError):  # such as SymPy's numbers
            return float(value)
        return {"other": repr(value)[:LONGEST_QUOTE]}

    def decoded(self, told: Any) -> Any:
        """Return the value that an encoded one stands for; functions call the other end."""
        if not isinstance(told, dict):
            return [*map(self.decoded, told)] if isinstance(told, list) else told
        match told:
            case {"list": list(entries)}:
                return [*map(self.decoded, entries)]
            case {"tuple": list(entries)}:
                return tuple(map(self.decoded, entries))
            case {"array": entries, "kind": str(kind), "shape": shape}:
                types = {"b": bool, "i": np.int64, "u": np.uint64, "f": np.float64}
                return np.array(entries, types[kind]).reshape(shape)[()]
            case {"dict": list(pairs)}:
                return {self.decoded(key): self.decoded(value) for key, value in pairs}
            case {"dots": True}:
                return ...
            case {"machine": str(text)}:
                from kinolab.dynamics.language.json.machine_file import machine_from_json

                return System.of(machine_from_json(text))
            case {"function": int(number)}:
                return lambda *arguments: self._called(number, arguments)
        return _Unreadable(str(told.get("other")))


def mark_from_afar(address: str, exercise: str, answer: Any) -> dict[str, Any]:
    """Have an answer judged by the process at an address; return its mark as plain data."""
    with Client(address, "AF_UNIX") as connection:
        peer = _Peer(connection)
        peer.send(exercise=exercise, answer=peer.encoded(answer))
        mark = peer.receive()["mark"]
        return dict(mark)


@contextmanager
def judging(judge: Callable[[str, Any], dict[str, Any]]) -> Iterator[str]:
    """Judge the answers that come to an address, one after the other.

    Args:
        judge: Returns the mark of an exercise's answer as plain data.

    Yields:
        The address, for processes of this computer's user.
    """
    # what a notebook has removed of it is not missed
    with TemporaryDirectory(prefix="kinolab-", ignore_cleanup_errors=True) as folder:
        address = str(Path(folder, "answers"))
        listener, ended = Listener(address, "AF_UNIX"), threading.Event()

        def judge_all() -> None:
            while not ended.is_set():
                with suppress(OSError, EOFError), listener.accept() as connection:
                    if not ended.is_set():
                        judge_one(connection, judge)

        threading.Thread(target=judge_all, daemon=True).start()
        try:
            yield address
        finally:
            ended.set()
            with suppress(OSError):
                Client(address, "AF_UNIX").close()  # accept() waits for somebody
            with suppress(OSError):
                listener.close()


def judge_one(connection: Connection, judge: Callable[[str, Any], dict[str, Any]]) -> None:
    """Judge the answer that comes by a connection, and tell its mark."""
    peer = _Peer(connection)
    with suppress(Exception):  # a notebook may send anything: then it has no mark
        asked = peer.receive()
        peer.send(mark=judge(str(asked["exercise"]), peer.decoded(asked["answer"])))


def processes_with(name: str, value: str) -> list[int]:
    """Return processes whose environment has a variable with a value, on Linux."""
    wanted, found = f"{name}={value}".encode(), []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if int(folder.name) != os.getpid():
                environment = (folder / "environ").read_bytes().split(b"\0")
                found += [int(folder.name)] * (wanted in environment)
    return found
