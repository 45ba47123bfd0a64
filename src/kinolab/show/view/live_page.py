"""A live page of a running search, served to this computer only.

Whoever may connect to this computer's own address is any account on it, and any page in its
browser. So the page's address has a secret part, without which nothing is answered; a request must
come by the server's own name, and from no other page. It can ask for the page, the events and the
finished page, and change nothing.
"""

from __future__ import annotations

import base64
import json
import secrets
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from kinolab.files import utf_8
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.graph import SearchGraph
from kinolab.show.page import page_html
from kinolab.show.scene.scenes import branches, content_of
from kinolab.trajectory import Trajectory

HOST = "127.0.0.1"
CLIENTS = 16  # most at once; a browser takes two or three
REQUEST_SECONDS = 10.0  # [s] for a client to send its request
PHASES = ("search", "verify", "optimise", "draw")  # in the order in which they come first
EVENTS, PLAN = "events", "plan"  # addresses, seen from the page
HEADERS = {  # of every answer
    "Cache-Control": "no-store",
    "Content-Security-Policy": "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
FETCH_SECONDS = 10.0  # [s] for a page to fetch the finished one


class LivePage:
    """The live page of a problem, with events to all its viewers.

    Attributes:
        address: URL for a browser on this computer.
    """

    def __init__(self, problem: PlanningTask, words: str) -> None:
        self._problem, self._news = problem, _News()
        self._begun, self._best = time.monotonic(), list[list[float]]()
        content = content_of(problem, None, {"status": "searching", "message": words}, drive=False)
        self._pages = {"": utf_8(page_html(replace(content, live=EVENTS)))}
        self._server = _Server(self._pages, self._news)
        self.address = f"http://{HOST}:{self._server.server_port}{self._server.root}"

    @contextmanager
    def served(self) -> Iterator[None]:
        """Serve the page inside, in a thread of its own."""
        thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._news.tell("end", "")
            self._server.shutdown()
            self._server.server_close()

    def say(self, words: str) -> None:
        """Show a status message."""
        self._news.tell("words", " ".join(words.split()))

    def explored(self, graph: SearchGraph) -> None:
        """Show the search graph so far."""
        self._news.tell("tree", _packed(branches(self._problem, graph)))

    def phase(self, name: str) -> None:
        """Show what is being done: one of ``PHASES``; what is none of them is not shown."""
        if name in PHASES:
            self._news.tell("phase", name)

    def found(self, trajectory: Trajectory) -> None:
        """Show the path of the machine along a motion, and how long the motion is."""
        poses = self._problem.model.frames(trajectory.x)
        places = poses[:, self._problem.leading, 3::4]
        self._news.tell("path", _packed(places))
        self._best.append([time.monotonic() - self._begun, trajectory.duration])
        self._news.tell("best", json.dumps(self._best))

    def verdict(self, status: str, message: str) -> None:
        """Show what came of it."""
        self._news.tell("verdict", json.dumps({"status": status, "message": message}))

    def end(self, page: bytes | None, *, expected: bool = False) -> None:
        """Redirect viewers to the finished page, and wait until all have fetched it.

        Args:
            page: The finished page; None leaves the live page as it is.
            expected: Whether a browser may still have to connect.
        """
        if expected:
            # 20.0 [s] for a browser that was just started to connect
            self._news.wait_for(lambda: self._news.came > 0, 20.0)
        if page is not None:
            self._pages[PLAN] = page
        self._news.tell("end", PLAN if page is not None else "")
        self._news.wait_for(lambda: self._news.listening == 0, FETCH_SECONDS)
        if page is not None:
            self._news.wait_for(lambda: self._news.fetched >= self._news.sent_on, FETCH_SECONDS)


class _News:
    """The newest event of each kind, and counts of listeners.

    Attributes:
        came: Number of listeners so far.
        listening: Number of current listeners.
        sent_on: Number of listeners redirected to the finished page.
        fetched: Number of times it was fetched.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._newest: dict[str, tuple[int, str]] = {}
        self._count = self.came = self.listening = self.sent_on = self.fetched = 0

    def tell(self, kind: str, text: str) -> None:
        """Publish an event; an unread one of the same kind is replaced."""
        with self._changed:
            self._count += 1
            self._newest[kind] = (self._count, text)
            self._changed.notify_all()

    def count(self, what: str, by: int = 1) -> None:
        """Change a count and notify."""
        with self._changed:
            setattr(self, what, getattr(self, what) + by)
            self._changed.notify_all()

    def since(self, number: int) -> tuple[int, list[tuple[str, str]]]:
        """Wait for events after a number; return the newest number, and (kind, text) in order."""
        with self._changed:
            # 5 [s] without events, after which a comment line detects closed connections
            self._changed.wait_for(lambda: self._count > number, 5.0)
            news = sorted((k, kind, text) for kind, (k, text) in self._newest.items() if k > number)
            return self._count, [(kind, text) for _, kind, text in news]

    def wait_for(self, held: Any, seconds: float) -> None:
        """Wait until a condition holds, or time runs out."""
        with self._changed:
            self._changed.wait_for(held, seconds)


class _Server(ThreadingHTTPServer):
    """Answers a few clients at once, each in a thread; what is too much is turned away.

    Attributes:
        root: The beginning of all its addresses, which nobody can guess.
    """

    daemon_threads = True

    def __init__(self, pages: dict[str, bytes], news: _News) -> None:
        super().__init__((HOST, 0), _Handler)
        self.pages, self.news = pages, news
        self.root = f"/{secrets.token_urlsafe()}/"
        self._free = threading.BoundedSemaphore(CLIENTS)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Begin a thread for a client, or hang up."""
        if self._free.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer a client, in its thread."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, *_: Any) -> None:
        """Ignore errors: the client is gone."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = 60.0  # [s] for a client to take an answer, as over a slow tunnel
    error_content_type = "text/plain; charset=utf-8"
    error_message_format = "%(code)d %(message)s\n"

    def setup(self) -> None:
        """Begin to count the time that a client has to ask."""
        super().setup()
        self._late = threading.Timer(REQUEST_SECONDS, self._hang_up)
        self._late.daemon = True
        self._late.start()

    def finish(self) -> None:
        """Say no more."""
        self._late.cancel()
        super().finish()

    def _hang_up(self) -> None:
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)

    def do_GET(self) -> None:
        """Answer a browser on this computer that addresses this server."""
        self._late.cancel()
        root, pages = self.server.root, self.server.pages
        name = self.path.removeprefix(root)
        if not self._is_from_here():
            self.send_error(403)
        elif not secrets.compare_digest(self.path[: len(root)].encode(), root.encode()):
            self.send_error(404)
        elif name == EVENTS:
            self._tell_events()
        elif name in pages:
            page = pages[name]
            self._begin("text/html; charset=utf-8", length=len(page))
            self.wfile.write(page)
            if name == PLAN:
                self.server.news.count("fetched")
        else:
            self.send_error(404)

    def _is_from_here(self) -> bool:
        """Whether a request is by the server's own name, as of no other site, and by no other page.

        Another site may give its name this computer's address (DNS rebinding).
        """
        port = self.server.server_port
        hosts, origins = (self.headers.get_all(key, []) for key in ("Host", "Origin"))
        own = {f"{HOST}:{port}", f"localhost:{port}"}
        return len(hosts) == 1 and {*hosts} <= own and {*origins} <= {f"http://{hosts[0]}"}

    def _begin(self, kind: str, **length: int) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        for size in length.values():
            self.send_header("Content-Length", str(size))
        self.end_headers()

    def end_headers(self) -> None:
        """End the headers with those of every answer."""
        for name, value in HEADERS.items():
            self.send_header(name, value)
        super().end_headers()

    def send_error(self, code: int, *_: Any) -> None:
        """Refuse a request, and repeat nothing of it."""
        super().send_error(code)

    def version_string(self) -> str:
        """Name the program, but no versions."""
        return "kinolab"

    def _tell_events(self) -> None:
        """Send server-sent events until the search has ended, or the client is gone.

        Source: HTML Living Standard, 9.2 Server-sent events.
        """
        news = self.server.news
        self._begin("text/event-stream")
        news.count("listening")
        news.count("came")
        try:
            number, ended = 0, False
            while not ended:
                number, events = news.since(number)
                for kind, text in events or [("", "")]:
                    line = f"event: {kind}\ndata: {text}\n\n" if kind else ": still here\n\n"
                    self.wfile.write(utf_8(line))
                    self.wfile.flush()
                    ended = ended or kind == "end"
            news.count("sent_on")
        except OSError:
            pass  # the client is gone, or takes nothing
        finally:
            news.count("listening", -1)

    def log_message(self, *_: Any) -> None:
        """Log nothing: stderr shows the progress of the search."""


def _packed(points: Array) -> str:
    """Return numbers as base64 of little-endian single precision."""
    return base64.b64encode(np.ascontiguousarray(points, dtype="<f4").tobytes()).decode()
