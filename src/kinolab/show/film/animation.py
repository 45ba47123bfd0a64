"""A plan as an animation: GIF, or MP4 encoded by PyAV."""

from __future__ import annotations

import io
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.lazy import library_of
from kinolab.problem import PlanningTask
from kinolab.show.film.film import Film, staged
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.staging.script_writing import motion_script
from kinolab.show.scene.camera import View
from kinolab.trajectory import Trajectory


def animate(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """Return the trajectory as an animated GIF."""
    return b"".join(gif_parts(staged(motion_script(problem, trajectory))))


def video(
    problem: PlanningTask,
    trajectory: Trajectory,
    *,
    size: tuple[int, int] | None = None,
    fps: float = 30.0,
    speed: float | None = None,
    view: View | Literal["follow"] | None = None,
) -> bytes:
    """Return the trajectory as an MP4 video.

    Args:
        trajectory: The motion.
        size: Width and height in [pixel], even; the scenario's if left out, as are speed and view.
        fps: Frames per second.
        speed: Seconds of motion per second of film.
        view: The camera's viewpoint; ``follow`` goes with the machine.

    Raises:
        InputError: If PyAV is not installed, or the size is odd.
    """
    given: dict[str, Any] = {"size": size, "speed": speed, "view": view}
    if view == "follow":
        given |= {"view": "perspective", "follow": True}
    changed = {name: value for name, value in given.items() if value}
    settings = problem.scenario.render.model_copy(update=changed)
    return mp4(staged(motion_script(problem, trajectory, settings, fps=fps, video=True)), fps)


def mp4(film: Film, fps: float) -> bytes:
    """Return a film as the bytes of an MP4 file.

    Args:
        fps: Frames per second, as the film was made for.

    Raises:
        InputError: If PyAV is not installed, or a side is odd, which H.264 cannot store.
    """
    size = film.script.size
    if any(side % 2 for side in size):
        what = f"{size[0]} x {size[1]} has an odd side, which H.264 cannot store."
        raise InputError([Mistake("size", what, "Give even numbers.")])
    av, out = library_of("video", "av", "films need PyAV"), io.BytesIO()
    with av.open(out, "w", format="mp4") as container:
        stream = container.add_stream(_codec(av), rate=Fraction(fps).limit_denominator(1001))
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.options = {"crf": "18", "preset": "medium"}  # x264 CRF, visually lossless
        image = None
        for image in film.frames():
            container.mux(stream.encode(_frame(av, image)))
        for _ in range(round(1.0 * fps)):  # [s] for which the last frame is shown
            container.mux(stream.encode(_frame(av, image)))
        container.mux(stream.encode())
    return out.getvalue()


def _codec(av: Any) -> str:
    # the first available
    return next(name for name in ("libx264", "h264", "mpeg4") if name in av.codecs_available)


def _frame(av: Any, image: Any) -> Any:
    return av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="rgb24")
