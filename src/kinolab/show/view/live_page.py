"""A page that shows a search while it goes on, served to this computer alone."""

from __future__ import annotations

import base64
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from kinolab.files import utf_8
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.graph import SearchGraph
from kinolab.show.page import page_html
from kinolab.show.view.scenes import branches, content_of
from kinolab.trajectory import Trajectory

HOST = "127.0.0.1"
EVENTS, PLAN = "/events", "/plan"
# [s] without news, after which a line that means nothing shows who is still there
HEARTBEAT_SECONDS = 5.0
FETCH_SECONDS = 10.0  # [s] that a page has to fetch the finished one
ARRIVAL_SECONDS = 20.0  # [s] that a browser which was just started has to come


class LivePage:
    """The page of a problem, and what is told to all who look at it.

    Args:
        problem: That is searched.
        words: What is going on, to begin with.

    Attributes:
        address: To be opened in a browser on this computer.
    """

    def __init__(self, problem: PlanningTask, words: str) -> None:
        self._problem, self._news = problem, _News()
        content = content_of(problem, None, {"status": "searching", "message": words}, drive=False)
        self._pages = {"/": utf_8(page_html(replace(content, live=EVENTS)))}
        self._server = _Server((HOST, 0), _Handler)
        self._server.pages, self._server.news = self._pages, self._news
        self.address = f"http://{HOST}:{self._server.server_port}/"

    @contextmanager
    def served(self) -> Iterator[None]:
        """Serve it inside, by a thread of its own."""
        thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._news.tell("end", "")
            self._server.shutdown()
            self._server.server_close()

    def say(self, words: str) -> None:
        """Tell what is going on."""
        self._news.tell("words", " ".join(words.split()))

    def explored(self, graph: SearchGraph) -> None:
        """Show what a search has explored so far."""
        self._news.tell("tree", _packed(branches(self._problem, graph)))

    def found(self, trajectory: Trajectory) -> None:
        """Show the way of the machine's first body along a motion."""
        places = self._problem.model.frames(trajectory.x)[:, 0, 3::4]
        self._news.tell("path", _packed(places))

    def end(self, page: bytes | None, *, expected: bool = False) -> None:
        """Hand over to the finished page, and wait until everybody who looks on has it.

        Args:
            page: The finished one; None leaves what is seen as it is.
            expected: Whether somebody comes who may not be there yet.
        """
        if expected:
            self._news.wait_for(lambda: self._news.came > 0, ARRIVAL_SECONDS)
        if page is not None:
            self._pages[PLAN] = page
        self._news.tell("end", PLAN if page is not None else "")
        self._news.wait_for(lambda: self._news.listening == 0, FETCH_SECONDS)
        if page is not None:
            self._news.wait_for(lambda: self._news.fetched >= self._news.sent_on, FETCH_SECONDS)


class _News:
    """The newest of each kind of event, and who waits for it.

    Attributes:
        came: How many have begun to listen.
        listening: How many listen now.
        sent_on: How many were told where the finished page is.
        fetched: How many times it was fetched.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._newest: dict[str, tuple[int, str]] = {}
        self._count = self.came = self.listening = self.sent_on = self.fetched = 0

    def tell(self, kind: str, text: str) -> None:
        """Tell everybody; what nobody has heard yet of the same kind is forgotten."""
        with self._changed:
            self._count += 1
            self._newest[kind] = (self._count, text)
            self._changed.notify_all()

    def count(self, what: str, by: int = 1) -> None:
        """Count somebody."""
        with self._changed:
            setattr(self, what, getattr(self, what) + by)
            self._changed.notify_all()

    def since(self, number: int) -> tuple[int, list[tuple[str, str]]]:
        """Wait for news after that number; return the newest number, and (kind, text) in order."""
        with self._changed:
            self._changed.wait_for(lambda: self._count > number, HEARTBEAT_SECONDS)
            news = sorted((k, kind, text) for kind, (k, text) in self._newest.items() if k > number)
            return self._count, [(kind, text) for _, kind, text in news]

    def wait_for(self, held: Any, seconds: float) -> None:
        """Wait until something holds, so long at most."""
        end = time.monotonic() + seconds
        with self._changed:
            while not held() and (left := end - time.monotonic()) > 0:
                self._changed.wait(min(left, 0.2))  # short, so that Ctrl-C is heard


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    pages: dict[str, bytes]
    news: _News

    def handle_error(self, *_: Any) -> None:
        """Say nothing: whoever asked is gone."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        """Answer a browser on this computer that means this server."""
        port = self.server.server_port
        if self.headers.get("Host") not in {f"{HOST}:{port}", f"localhost:{port}"}:
            self.send_error(403)  # a page from elsewhere, whose name was made to point here
        elif self.path == EVENTS:
            self._tell_events()
        elif self.path in self.server.pages:
            page = self.server.pages[self.path]
            self._begin("text/html; charset=utf-8", length=len(page))
            self.wfile.write(page)
            if self.path == PLAN:
                self.server.news.count("fetched")
        else:
            self.send_error(404)

    def _begin(self, kind: str, **length: int) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        for size in length.values():
            self.send_header("Content-Length", str(size))
        self.end_headers()

    def _tell_events(self) -> None:
        """Send server-sent events until the search has ended, or nobody listens any more.

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
        except ConnectionError:
            pass  # nobody listens any more
        finally:
            news.count("listening", -1)

    def log_message(self, *_: Any) -> None:
        """Say nothing: stderr tells how the search goes."""


def _packed(points: Array) -> str:
    """Return numbers as base64 of single precision, smallest byte first."""
    return base64.b64encode(np.ascontiguousarray(points, dtype="<f4").tobytes()).decode()
