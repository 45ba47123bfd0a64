"""The side of the process that draws a film: its messages, and what it does.

Only what draws is imported, no machine and no world.
"""

from __future__ import annotations

import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection

from kinolab.numerics.compiling import compilation
from kinolab.processes.serving import leave_with, serve
from kinolab.show.film.changes import change
from kinolab.show.film.film import Film
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.palette import shared_palette
from kinolab.show.film.raster.draw_list import FloorPaint, Shadows, Solid, drawn
from kinolab.show.film.raster.light import LIGHT_SAMPLES
from kinolab.show.film.raster.rasterizer import NO_FACETS, average, extent
from kinolab.show.film.scene import PAPER

SMALL = 8  # [pixel] per side of the picture that is drawn beforehand


@dataclass(frozen=True)
class Compiling:
    """An inner loop is being compiled."""

    functions: int
    seconds: float


@dataclass(frozen=True)
class Drawn:
    """The finished file."""

    content: bytes


@dataclass(frozen=True)
class DrawingFailed:
    """Drawing has failed."""

    reason: str
    of_memory: bool


def enter(handle: int) -> None:
    """Entry point of the process: get ready, draw the film that is sent, and leave.

    Args:
        handle: File descriptor of the connection to the process that started this one.
    """
    serve(handle, _draw)


def _draw(connection: Connection) -> None:
    load()
    film, size = connection.recv()
    leave_with(connection)
    connection.send(_result(connection, film, size))


def load() -> None:
    """Load all compiled loops of a film, by drawing nothing."""
    layers = [Solid(NO_FACETS), FloorPaint(NO_FACETS), Shadows([NO_FACETS.corners] * LIGHT_SAMPLES)]
    image = average(drawn(layers, (SMALL, SMALL), PAPER).color, 1)
    extent(NO_FACETS.corners, (SMALL, SMALL))
    palette = shared_palette([image])
    shown = palette.indices(image)
    change(shown, shown, [])


def _result(connection: Connection, film: Film, size: tuple[int, int]) -> Drawn | DrawingFailed:
    try:
        with compilation(lambda one: connection.send(Compiling(one.functions, one.seconds))):
            return Drawn(b"".join(gif_parts(film, size)))
    except (BrokenPipeError, ConnectionResetError):
        raise  # nobody waits for it
    except MemoryError:
        return DrawingFailed("", of_memory=True)
    except Exception:
        return DrawingFailed(traceback.format_exc(), of_memory=False)
