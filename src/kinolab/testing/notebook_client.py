"""What runs a notebook and keeps little of what it prints."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import zmq
from nbclient import NotebookClient
from traitlets.config import Config


class ThriftyClient(NotebookClient):
    """Keeps outputs up to a size, and takes no message beyond it.

    Attributes:
        most: Largest size of all outputs, and of one message, in bytes.
        printed: Size of all outputs so far, in bytes.
        started: Whether the notebook's process has answered.
    """

    most = 0
    printed = 0
    started = False

    async def async_start_new_kernel_client(self) -> Any:
        """Start a client that hangs up on messages which are too large."""
        manager: Any = self.km
        make = manager.client

        def client(**options: Any) -> Any:
            made = make(**options)
            made.context.setsockopt(zmq.MAXMSGSIZE, self.most)
            return made

        manager.client = client
        ready = await super().async_start_new_kernel_client()
        self.started = True
        return ready

    async def async_start_new_kernel(self, **options: Any) -> None:
        """Start a process that writes nothing to this one's terminal."""
        nowhere = dict.fromkeys(("stdout", "stderr"), subprocess.DEVNULL)
        await super().async_start_new_kernel(**options, **nowhere)

    def output(self, outs: Any, msg: Any, display_id: Any, cell_index: int) -> Any:
        """Add an output to those of a cell, unless there have been enough."""
        self.printed += len(repr(msg["content"]))
        if self.printed > self.most and msg["msg_type"] != "error":
            return None
        return super().output(outs, msg, display_id, cell_index)


def client_of(notebook: Any, folder: str, seconds: int, most: int, place: str) -> ThriftyClient:
    """Return a client that runs a notebook in a folder.

    It talks to the notebook's process by files that nobody else of the computer can open; by ports,
    as Jupyter does otherwise, others could listen, of which its process warns.

    Args:
        notebook: As nbformat reads it.
        folder: In which it runs.
        seconds: Limit of each cell, in [s].
        most: Size of all outputs that are kept, in bytes.
        place: A folder of its own, for those files.
    """
    by_files = {"transport": "ipc", "ip": str(Path(place, "line"))}
    client = ThriftyClient(
        notebook, timeout=seconds, allow_errors=True,
        resources={"metadata": {"path": folder}}, kernel_name="python3",
        config=Config({"KernelManager": by_files}),
    )  # fmt: skip
    client.most = most
    return client
