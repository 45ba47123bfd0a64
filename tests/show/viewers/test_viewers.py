"""Rerun and MeshCat get the machine where the equations say it is."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.show.viewers import show_in_meshcat, show_in_rerun
from kinolab.show.viewers.viewed_parts import unique
from tests.support import needs

RERUN = shutil.which("rerun", path=str(Path(sys.executable).parent))


class Recorder:
    """What MeshCat's visualizer is asked to draw, by path."""

    def __init__(self, path: str = "", calls: list[tuple[str, str, Any]] | None = None) -> None:
        self.path, self.calls = path, [] if calls is None else calls

    def __getitem__(self, name: str) -> Recorder:
        return Recorder(f"{self.path}/{name}", self.calls)

    def __getattr__(self, what: str) -> Any:
        return lambda *given: self.calls.append((self.path, what, given))


@pytest.fixture(scope="module")
def swing() -> Any:
    problem = kinolab.load("pendulum_swingup")
    return problem, kinolab.simulate(problem, duration=2.0, start={"theta": 0.5})


def printed(path: Path) -> str:
    """Return what Rerun's own reader finds in a recording."""
    assert RERUN is not None
    done = subprocess.run(
        [RERUN, "rrd", "print", str(path)], capture_output=True, text=True, check=True
    )
    return done.stdout


@needs("rerun")
def test_rerun_s_reader_finds_bodies_states_and_inputs(swing: Any, tmp_path: Path) -> None:
    problem, motion = swing
    show_in_rerun(problem, motion, tmp_path / "run.rrd")
    text = printed(tmp_path / "run.rrd")
    told = re.findall(r"with (\d+) rows.*? - (/.*?) - data", text)
    rows: dict[str, int] = {}
    for count, path in told:
        rows[path] = max(int(count), rows.get(path, 0))
    assert rows["/world/machine/bob"] == 61  # 2 s, 30 times a second, and the end
    assert rows[r"/States/theta\ \[rad\]"] == len(motion.t)
    assert rows[r"/Inputs/torque\ \[N\ m\]"] == len(motion.u)
    assert "Mesh3D:vertex_positions" in text


@needs("meshcat")
def test_meshcat_animates_the_bob_along_its_circle(swing: Any) -> None:
    problem, motion = swing
    recorder = Recorder()
    show_in_meshcat(problem, motion, recorder)
    drawn = {path for path, what, _ in recorder.calls if what == "set_object"}
    assert "/kinolab/machine/bob" in drawn
    (animation,) = next(given for _, what, given in recorder.calls if what == "set_animation")
    track = animation.clips["/kinolab/machine/bob"].tracks["quaternion"]
    assert len(track.values) == 61
    assert np.linalg.norm(track.values, axis=1) == pytest.approx(np.ones(61))
    # The rotation from first to k-th key is as large as the angle has changed.
    first = np.array(track.values[0])
    turned = 2 * np.arccos(np.clip(np.abs(np.array(track.values) @ first), 0, 1))
    angles = motion.at(np.linspace(0, 2, 61)).x[:, 0]
    assert turned == pytest.approx(np.abs(angles - angles[0]), abs=1e-3)


@needs("meshcat")
def test_meshcat_s_own_server_takes_it_and_writes_a_page(swing: Any) -> None:
    view = show_in_meshcat(*swing)
    try:
        page = view.static_html()
    finally:
        view.window.server_proc.kill()
        view.window.server_proc.wait()
        view.window.zmq_socket.close(linger=0)
        view.window.context.term()
    assert (
        page.count("data:application/octet-binary;base64,") > 3
    )  # commands that MeshCat replays: objects, poses, animation
    assert "127.0.0.1" in view.url() or "localhost" in view.url()


def test_names_become_branches_of_their_own() -> None:
    assert unique(["a", "a", "b/c", ""]) == ["a", "a 2", "b c", "part"]
