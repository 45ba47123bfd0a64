"""viser's server, open to one browser of this computer: to no other site, account or machine.

Whoever may connect to this computer's own address is any account on it, and any page in its
browser. So the page's address has a secret part, without which nothing is answered; a request must
come by the server's own name, and from no other page. All of this is asked before viser sees the
request, of pages and of websockets. Beyond that, the page may reach nobody but this server.

Where: viser passes ``process_request`` to ``websockets``, which is wrapped here.
"""

from __future__ import annotations

import functools
import http
import io
import secrets
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from types import MappingProxyType
from typing import Any

import viser
from viser import _messages as messages
from viser.infra import _infra as infra
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from kinolab.studio.core.chosen_folder import SIZE_LIMIT

HOST = "127.0.0.1"
PART_SIZE = 512 * 1024  # [bytes] of a piece of it, as viser's client sends them
HEADERS = {  # of every answer
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
# of the page: viser's client is one file with its scripts, workers and fonts inside
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob: data:; "
    "worker-src blob: data:; style-src 'unsafe-inline'; img-src data: blob:; "
    "font-src data: blob:; media-src data: blob:; connect-src ws://{host} data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

Handler = Callable[[Any, Request], Response | None]


class Guard:
    """What is asked of every request, before it is answered.

    Args:
        pages: Further pages, by their names below the root.

    Attributes:
        root: The beginning of the page's address, which nobody can guess.
    """

    def __init__(self, pages: Mapping[str, bytes]) -> None:
        self.root, self._pages = f"/{secrets.token_urlsafe()}", pages

    def wrap(self, answer: Handler) -> Handler:
        """Return a handler that answers only what may be asked."""

        def guarded(connection: Any, request: Request) -> Response | None:
            host = f"{HOST}:{connection.local_address[1]}"
            refusal = self._refusal(request, host)
            if refusal is not None:
                return _finished(Response(refusal, refusal.phrase, Headers(), b""), host)
            if request.headers.get("Upgrade", "").lower() == "websocket":
                return None
            page = self._pages.get(request.path.partition("?")[0].removeprefix(f"{self.root}/"))
            if page is not None:
                kind = Headers({"Content-Type": "text/html; charset=utf-8"})
                kind["Content-Length"] = str(len(page))
                return _finished(Response(200, "OK", kind, page), host)
            request.path = "/"
            response = answer(connection, request)
            return None if response is None else _finished(response, host)

        return guarded

    def _refusal(self, request: Request, host: str) -> http.HTTPStatus | None:
        """Return why a request is refused; None where it may be answered."""
        named, origins = (request.headers.get_all(key) for key in ("Host", "Origin"))
        if named != [host] or not set(origins) <= {f"http://{host}"} or len(origins) > 1:
            return http.HTTPStatus.FORBIDDEN
        path = request.path.partition("?")[0]
        allowed = (self.root, f"{self.root}/", *(f"{self.root}/{name}" for name in self._pages))
        if not any(secrets.compare_digest(path.encode(), one.encode()) for one in allowed):
            return http.HTTPStatus.NOT_FOUND
        upgrades = [value.lower() for value in request.headers.get_all("Upgrade")]
        if upgrades and (upgrades != ["websocket"] or not origins):
            return http.HTTPStatus.FORBIDDEN  # every browser says where a websocket is from
        return None


def _finished(response: Response, host: str) -> Response:
    for name, value in HEADERS.items():
        response.headers[name] = value
    response.headers["Content-Security-Policy"] = POLICY.format(host=host)
    return response


def guarded_server(
    label: str, pages: Mapping[str, bytes] = MappingProxyType({})
) -> tuple[viser.ViserServer, str]:
    """Start viser behind a guard on a free port of this computer's own address.

    Args:
        label: The title of its panel.
        pages: Further pages of its, by their names; others may be added later.

    Returns:
        The server, and the address of its page with the secret part.
    """
    guard, library = Guard(pages), infra.websockets.asyncio.server
    serve = library.serve

    @functools.wraps(serve)
    def guarded(*arguments: Any, **options: Any) -> Any:
        options["process_request"] = guard.wrap(options["process_request"])
        return serve(*arguments, **options)

    library.serve = guarded
    try:
        with redirect_stdout(io.StringIO()):  # it prints an address that answers nobody
            server = viser.ViserServer(HOST, 0, label, verbose=False)
    finally:
        library.serve = serve
    web = server._websock_server
    for kind in (messages.ShareUrlRequest, messages.ShareUrlDisconnect):
        web.unregister_handler(kind)  # which would open a way in for the whole world
    _limit_files(server)
    return server, f"http://{HOST}:{server.get_port()}{guard.root}/"


def _limit_files(server: viser.ViserServer) -> None:
    """Let no file into memory that is too large, or larger than it says."""
    web, take = server._websock_server, server.gui._handle_file_transfer_start

    def start(client: Any, message: messages.FileTransferStartUpload) -> None:
        pieces = message.part_count * PART_SIZE
        if 0 <= message.size_bytes <= SIZE_LIMIT and pieces <= SIZE_LIMIT + PART_SIZE:
            take(client, message)

    web.unregister_handler(messages.FileTransferStartUpload)
    web.register_handler(messages.FileTransferStartUpload, start)
