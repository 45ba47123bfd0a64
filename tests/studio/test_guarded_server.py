"""Nobody but the page with the secret address gets an answer of the studio's server."""

from __future__ import annotations

import base64
import http.client
import socket
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest

viser = pytest.importorskip("viser")
from websockets.exceptions import InvalidHandshake  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from kinolab.studio.core.chosen_folder import SIZE_LIMIT  # noqa: E402
from kinolab.studio.guarded_server import guarded_server  # noqa: E402


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[Any, str]]:
    server, address = guarded_server("a test")
    yield server, address
    server.stop()


def asked(address: str, raw: bytes) -> bytes:
    """Return all that a server answers to bytes."""
    place = urlsplit(address)
    with socket.create_connection((place.hostname, place.port), timeout=5) as wire:
        wire.sendall(raw)
        wire.settimeout(5)
        answer = b""
        try:
            while piece := wire.recv(65536):
                answer += piece
        except (TimeoutError, ConnectionResetError):
            pass
    return answer


def request(address: str, path: str | None = None, method: str = "GET", **headers: Any) -> bytes:
    place = urlsplit(address)
    lines = {"Host": place.netloc, "Connection": "close", **headers}
    told = [f"{method} {place.path if path is None else path} HTTP/1.1"]
    for name, values in lines.items():
        for value in values if isinstance(values, list) else [values]:
            if value is not None:
                told.append(f"{name.replace('_', '-')}: {value}")
    return "\r\n".join([*told, "", ""]).encode()


SOCKET = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": base64.b64encode(b"0123456789abcdef").decode(),
    "Sec_WebSocket_Protocol": f"viser-v{viser.__version__}",
}
HOSTILE: dict[str, Any] = {
    "no secret": {"path": "/"},
    "a wrong secret": {"path": "/AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA/"},
    "half of the secret": {"path": "half"},
    "a file beside the page": {"path": "beside"},
    "another page without the secret": {"path": "/drive"},
    "another page that was never made": {"path": "drive"},
    "a way out of the folder": {"path": "/../../../../etc/passwd"},
    "a way out that is hidden": {"path": "/%2e%2e/%2e%2e/etc/passwd"},
    "a way out behind the secret": {"path": "out"},
    "the page by another name": {"Host": "evil.example"},
    "this computer's name without a port": {"Host": "127.0.0.1"},
    "no name": {"Host": None},
    "two names": {"Host": ["own", "evil.example"]},
    "from another page": {"Origin": "http://evil.example"},
    "from a page without an origin": {"Origin": "null"},
    "from another port": {"Origin": "http://127.0.0.1:1"},
    "from two pages": {"Origin": ["own", "http://evil.example"]},
    "a post": {"method": "POST", "Content_Length": "0"},
    "a put": {"method": "PUT", "Content_Length": "0"},
    "a deletion": {"method": "DELETE"},
    "a socket without the secret": {"path": "/", "Origin": "own", **SOCKET},
    "a socket from another page": {"Origin": "http://evil.example", **SOCKET},
    "a socket from nowhere": SOCKET,
    "a socket by another name": {"Host": "evil.example", "Origin": "http://evil.example", **SOCKET},
    "another kind of socket": {**SOCKET, "Upgrade": "h2c", "Origin": "own"},
}


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_request_is_refused(served: tuple[Any, str], what: str) -> None:
    _, address = served
    place = urlsplit(address)
    given = dict(HOSTILE[what])
    paths = {
        "half": place.path[:10],
        "beside": f"{place.path}index.html",
        "out": f"{place.path}../../etc/passwd",
        "drive": f"{place.path}drive",
    }
    if "path" in given:
        given["path"] = paths.get(given["path"], given["path"])
    own = {"Host": place.netloc, "Origin": f"http://{place.netloc}"}
    for key, value in own.items():
        if key in given:
            given[key] = (
                [value if v == "own" else v for v in given[key]]
                if isinstance(given[key], list)
                else value
                if given[key] == "own"
                else given[key]
            )
    answer = asked(address, request(address, **given))
    assert not answer.startswith((b"HTTP/1.1 200", b"HTTP/1.1 101")), answer[:200]
    assert b"viser" not in answer
    assert b"root:" not in answer
    assert place.path.strip("/").encode() not in answer


def test_the_page_itself_is_answered_and_may_reach_nobody_else(served: tuple[Any, str]) -> None:
    _, address = served
    place = urlsplit(address)
    wire = http.client.HTTPConnection(place.netloc, timeout=5)
    wire.request("GET", place.path, headers={"Accept-Encoding": "identity"})
    answer = wire.getresponse()
    assert answer.status == 200
    assert b"<html" in answer.read()
    wire.close()
    policy = answer.headers["Content-Security-Policy"]
    reached = [part.strip() for part in policy.split(";") if part.strip().startswith("connect-src")]
    assert reached == [f"connect-src ws://{place.netloc} data: blob:"]
    assert "https:" not in policy
    assert answer.headers["Referrer-Policy"] == "no-referrer"


def test_the_page_s_own_socket_is_open(served: tuple[Any, str]) -> None:
    _, address = served
    place, protocol = urlsplit(address), SOCKET["Sec_WebSocket_Protocol"]
    with connect(
        f"ws://{place.netloc}{place.path[:-1]}",
        origin=f"http://{place.netloc}",  # type: ignore[arg-type]
        subprotocols=[protocol],  # type: ignore[list-item]
        proxy=None,
    ) as wire:
        assert len(wire.recv(timeout=5)) > 0
    with pytest.raises(InvalidHandshake):
        connect(f"ws://{place.netloc}{place.path[:-1]}", proxy=None)


def test_it_listens_on_this_computer_s_own_address_alone(served: tuple[Any, str]) -> None:
    server, _ = served
    with pytest.raises(OSError, match=r"refused|unreachable"):
        socket.create_connection(("127.0.0.2", server.get_port()), timeout=2)


def test_files_that_are_too_large_are_not_taken_and_no_way_in_from_outside_is_opened(
    served: tuple[Any, str],
) -> None:
    from viser import _messages as messages

    server, _ = served
    handlers = server._websock_server._incoming_handlers
    assert messages.ShareUrlRequest not in handlers
    button = server.gui.add_upload_button("a mesh")
    (start,) = handlers[messages.FileTransferStartUpload]
    taken = server.gui._current_file_upload_states
    sizes = {"huge": (SIZE_LIMIT + 1, 1), "many": (10, 10_000), "negative": (-1, 1), "fits": (9, 1)}
    for name, (size, parts) in sizes.items():
        start(0, messages.FileTransferStartUpload(button._impl.uuid, name, name, "x", parts, size))
    assert set(taken) == {"fits"}
