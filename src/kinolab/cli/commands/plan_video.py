"""``plan video``: render a finished run as a video."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from kinolab.cli.common import PATH, quiet_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import escaped, say

VIEWS = click.Choice(["perspective", "top", "front", "side", "follow"])
LEAST, MOST = 16, 4096  # [pixel] per side


class Size(click.ParamType[Any]):
    """Width and height, written as 1280x720."""

    name = "WxH"

    def convert(self, value: Any, param: Any, _: Any) -> tuple[int, int]:
        """Parse it, or reject it with a hint."""
        found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", str(value))
        sides = tuple(map(int, found.groups())) if found else (0, 0)
        if not all(LEAST <= side <= MOST and side % 2 == 0 for side in sides):
            self.fail(f"{value!r}: give even numbers from {LEAST} to {MOST}, as 1280x720.", param)
        return sides[0], sides[1]


@click.command("video")
@click.argument("folder", type=PATH)
@click.option("--size", type=Size(), help="In pixels; the scenario's if left out.")
@click.option("--fps", type=click.FloatRange(1.0, 240.0), default=30.0, show_default=True)
@click.option("--speed", type=click.FloatRange(0.0, min_open=True), help="Of the motion.")
@click.option("--view", type=VIEWS, help="The scenario's if left out.")
@click.option("--out", type=PATH, help="Instead of animation.mp4.")
@quiet_option
def command(
    folder: Path,
    size: tuple[int, int] | None,
    fps: float,
    speed: float | None,
    view: Any,
    out: Path | None,
    quiet: bool,
) -> int:
    """Film the plan of a finished run, as animation.mp4 in its folder.

    Needs the extra "video".
    """
    from kinolab.files import write_whole
    from kinolab.runs import read_run
    from kinolab.show.film.animation import video

    progress = Progress(quiet)
    progress("reading the run and compiling the machine")
    run = read_run(folder)
    progress("filming")
    made = video(run.problem, run.trajectory, size=size, fps=fps, speed=speed, view=view)
    progress.close()
    path = out or folder / "animation.mp4"
    with INTERRUPTS.writing():
        write_whole(path, made)
    say(escaped(str(path)))
    return 0
