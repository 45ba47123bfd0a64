"""A page that shows a search while it goes on: what is told, to whom, and how it ends."""

from __future__ import annotations

import base64
import http.client
import re
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.graph import SearchGraph
from kinolab.show.view import live_page
from kinolab.show.view.live_page import LivePage
from kinolab.solve import solve
from tests.show.view.browsing import Opener, needs_chromium, until
from tests.support import OPEN, WALL, plan, problem_of

EVENT = re.compile(rb"event: (\w+)\ndata: (.*)\n\n")


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("live"), OPEN + WALL)


@pytest.fixture
def live(problem: PlanningTask) -> Iterator[LivePage]:
    page = LivePage(problem, "it begins")
    with page.served():
        yield page


def ask(live: LivePage, path: str, method: str = "GET", **headers: str) -> http.client.HTTPResponse:
    """Ask for what an address seen from the page is; one that begins with / is the server's."""
    place = urlsplit(urljoin(live.address, path))
    connection = http.client.HTTPConnection(place.netloc, timeout=20)
    connection.request(method, place.path, headers=headers)
    return connection.getresponse()


def cross(problem: PlanningTask) -> SearchGraph:
    """Four states about the first one, which is where the start is."""
    x = np.repeat(problem.start[None], 5, axis=0)
    x[1:, :2] += [[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]]
    return SearchGraph(x, np.array([[0, 1], [0, 2], [0, 3], [0, 4]]))


def test_everybody_hears_the_newest_of_all_that_was_told(
    live: LivePage, problem: PlanningTask
) -> None:
    """The first body of the coin is at the state's own x and y."""
    live.say("one")
    live.say("two\nlines")
    live.explored(cross(problem))
    stream = ask(live, "events")
    threading.Thread(target=live.end, args=(None,)).start()
    told = EVENT.findall(stream.read())
    assert [kind for kind, _ in told] == [b"words", b"tree", b"end"]
    assert told[0][1] == b"two lines"
    places = np.frombuffer(base64.b64decode(told[1][1]), "<f4").reshape(4, 2, 3)
    assert places[:, 0, :2] == pytest.approx(np.tile(problem.start[:2], (4, 1)))
    moves = places[:, 1, :2] - places[:, 0, :2]
    assert moves == pytest.approx(np.array([[0.5, 0], [0, 0.5], [-0.5, 0], [0, -0.5]]))


def test_only_this_computer_is_answered_and_only_by_this_server_s_name(live: LivePage) -> None:
    """Another site's page comes by its own name, or says where it comes from."""
    place = urlsplit(live.address)
    assert place.hostname == "127.0.0.1"
    with socket.socket() as other:  # another address, of this computer again
        other.settimeout(2)
        assert other.connect_ex(("127.0.0.2", place.port)) != 0
    assert ask(live, "").status == 200
    assert ask(live, "", Host=f"localhost:{place.port}").status == 200
    for path in ("", "events", "plan"):
        for host in ("elsewhere.example", f"elsewhere.example:{place.port}", "127.0.0.1", ""):
            assert ask(live, path, Host=host).status == 403
        for origin in (
            "https://elsewhere.example",
            "null",
            "http://127.0.0.1:1",
            f"http://{place.netloc}.example",
        ):
            assert ask(live, path, Origin=origin).status == 403
    assert ask(live, "", Origin=f"http://{place.netloc}").status == 200


def test_nothing_is_served_but_the_page_and_that_only_to_who_knows_its_address(
    live: LivePage,
) -> None:
    secret = urlsplit(live.address).path
    assert len(secret) > 30
    for path in ("/", "/events", "/plan", secret[:-1], secret.upper(), f"{secret[:-2]}x/"):
        assert ask(live, path).status == 404
    for name in (
        *("../pyproject.toml", "..%2fpyproject.toml", "%2e%2e/%2e%2e/etc/passwd", "./", "plan"),
        *("/etc/passwd", "//etc/passwd", "events/", "events?x", "%00", "events%00", "scene.html"),
        f"http://elsewhere.example{secret}",
    ):
        for path in (secret + name, name):
            assert status_of(live, f"GET {path} HTTP/1.1") == 404
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "HEAD", "CONNECT", "TRACE"):
        assert ask(live, "", method).status == 501


def status_of(live: LivePage, line: str) -> int:
    return int(answer_to(live, line).split(maxsplit=2)[1])


def answer_to(live: LivePage, line: str) -> bytes:
    """Send a request as it is written, and return the answer."""
    place = urlsplit(live.address)
    with socket.create_connection((place.hostname, place.port), timeout=20) as client:
        client.sendall(f"{line}\r\nHost: {place.netloc}\r\n\r\n".encode())
        return client.makefile("rb").read()


def test_every_answer_forbids_what_a_browser_might_do_with_it(live: LivePage) -> None:
    for answer in (ask(live, ""), ask(live, "nothing"), ask(live, "", Host="elsewhere.example")):
        told = {name.lower(): value for name, value in answer.getheaders()}
        assert told["x-content-type-options"] == "nosniff"
        assert told["cross-origin-resource-policy"] == "same-origin"
        assert "frame-ancestors 'none'" in told["content-security-policy"]
        assert not any(name.startswith("access-control-") for name in told)
        assert "python" not in told["server"].lower()
    assert b"default-src 'none'" in ask(live, "").read()
    assert b"hacked" not in answer_to(live, "<script>hacked</script> / HTTP/1.1")


def test_clients_that_are_slow_or_many_hold_up_neither_others_nor_the_end(
    problem: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One asks for ever, one takes no answer, and as many as one likes say nothing."""
    monkeypatch.setattr(live_page, "REQUEST_SECONDS", 0.3)
    monkeypatch.setattr(live_page, "FETCH_SECONDS", 0.5)
    page = LivePage(problem, "it begins")
    place = urlsplit(page.address)
    assert live_page.CLIENTS < 40
    with ExitStack() as opened, page.served():
        clients = [
            opened.enter_context(socket.create_connection((place.hostname, place.port), timeout=20))
            for _ in range(40)
        ]
        clients[0].sendall(b"GET / HTTP/1.1\r\nHost: ")
        clients[1].sendall(
            f"GET {place.path}events HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode()
        )
        for client in (clients[0], *clients[2:]):  # all of them are left, none is answered
            with suppress(ConnectionError):
                assert client.recv(100) == b""
        assert ask(page, "").status == 200
        page.end(None)  # although the second one has not read it


@pytest.mark.parametrize("planner", ["rrt_fast", "rrt"])
def test_planners_show_trees_that_begin_at_the_start_and_grow(tmp_path: Path, planner: str) -> None:
    seen: list[SearchGraph] = []

    def watch(budget: Budget) -> None:
        budget.viewer = seen.append

    hard = problem_of(tmp_path, OPEN + WALL, "goal.tolerance=0.0001")
    solve(hard, planner, 1, 20.0, max_iterations=6000, optimize=False, watch=watch)
    assert seen
    for graph in seen:
        assert np.abs(graph.x - hard.start).max(axis=1).min() < 1e-9
        assert not len(graph.edges) or graph.edges.max() < len(graph.x)
    assert len(seen[-1].x) >= len(seen[0].x)


def test_stages_are_told_in_the_order_in_which_they_begin(tmp_path: Path) -> None:
    told: list[str] = []

    def watch(budget: Budget) -> None:
        budget.stage = told.append

    solve(problem_of(tmp_path, OPEN), "rrt_fast", 1, 20.0, max_iterations=6000, watch=watch)
    assert told[:3] == ["search", "simulate", "verify"]


@needs_chromium
def test_the_page_shows_the_tree_and_then_the_finished_plan(
    live: LivePage, problem: PlanningTask, browse: Opener, tmp_path: Path
) -> None:
    page = browse(live.address)
    shown = page.locator("#view")
    before = shown.screenshot()
    assert page.inner_text("#badge") == "Searching"
    live.say("half of it is done")
    live.explored(cross(problem))
    live.phase("search")
    until(page, "document.getElementById('subtitle').innerText === 'half of it is done'")
    page.wait_for_timeout(300)
    assert shown.screenshot() != before
    assert page.inner_text(".phases [aria-current]") == "Searching"
    solved = problem.solve(planner="rrt_fast", seed=1, max_iterations=20_000)
    assert solved.trajectory is not None
    live.phase("optimise")
    live.found(solved.trajectory)
    live.verdict("not_found", "It was only a trial.")
    until(page, "document.getElementById('badge').innerText === 'No plan found'")
    assert page.inner_text(".phases [aria-current]") == "Optimising"
    assert f"{solved.trajectory.duration:.4g} s" in page.inner_text(".best")
    finished = kinolab.save_page(problem, solved, tmp_path / "scene.html").read_bytes()
    ending = threading.Thread(target=live.end, args=(finished,))
    ending.start()
    page.wait_for_url("**/plan")
    page.evaluate("async () => { await kinolab.ready; }")
    assert page.inner_text("#badge") == "Solved and verified"
    assert page.evaluate("kinolab.last") == pytest.approx(solved.trajectory.duration)
    ending.join(20)
    assert not ending.is_alive()


def test_the_command_ends_where_nobody_looks_on(tmp_path: Path) -> None:
    (tmp_path / "open.toml").write_text(OPEN)
    options = ("--live", "--no-browser", "--quiet", "--no-animation")
    done = plan("open.toml", *options, cwd=tmp_path, timeout=120)
    assert done.returncode == 0
    assert re.search(r"live on http://127\.0\.0\.1:\d+/", done.stderr)


def test_several_searches_are_not_shown_on_one_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rolling_disk_maze", "--live", "--jobs", "2"]) == 2
    assert "--live: a page shows one search. Leave --jobs out." in capsys.readouterr().err
