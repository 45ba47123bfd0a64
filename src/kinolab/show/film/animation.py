"""A plan as an animation: GIF or MP4."""

from __future__ import annotations

from typing import Any, Literal

from kinolab.problem import PlanningTask
from kinolab.show.film.film import staged
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.mp4 import mp4
from kinolab.show.film.raster.camera import View
from kinolab.show.film.staging.motion_script import motion_script
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
        problem: The machine and its world.
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
