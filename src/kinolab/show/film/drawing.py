"""The side of the process that draws films.

Only what draws is imported, no machine and no world. Orders are read by a thread of their own, so
that a newer one, or the end of the process that sends them, is noticed while a film is drawn.
"""

from __future__ import annotations

import os
import threading
import traceback
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.connection import Connection

from kinolab.concurrency.processors import processors
from kinolab.numerics.compiling import compilation
from kinolab.show.film.crew import Crew, Share, everything
from kinolab.show.film.film_messages import (
    Compiling,
    DrawingFailed,
    Drawn,
    Final,
    Order,
    Scenery,
)
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.palette import shared_palette
from kinolab.show.film.picture import Surface
from kinolab.show.film.raster.draw_list import FloorPaint, Shadows, Solid, drawn
from kinolab.show.film.raster.light import LIGHT_SAMPLES
from kinolab.show.film.raster.rasterizer import NO_FACETS, average, blank, extent, reveal
from kinolab.show.film.scene import PAPER
from kinolab.show.film.staging.set_up import staged

SMALL = 8  # [pixel] per side of the picture that is drawn beforehand


class OrderBook:
    """What is to be drawn, as it is told by the process that started this one."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._obstacles: Sequence[Surface] = ()
        self._newest: Order | None = None
        self._changed = threading.Condition()
        self._final = False
        threading.Thread(target=self._read, daemon=True).start()

    def after(self, number: int) -> Order:
        """Wait for an order that is newer than the one with a number."""
        with self._changed:
            while not self.beyond(number):
                self._changed.wait()
            assert self._newest is not None
            picture = replace(self._newest.script.picture, obstacles=self._obstacles)
            return replace(self._newest, script=replace(self._newest.script, picture=picture))

    def beyond(self, number: int) -> bool:
        """Say whether there is a newer order than the one with a number."""
        return self._newest is not None and self._newest.number > number

    def share(self) -> Share:
        """What drawing may take: until the film is waited for, what the search leaves."""
        return everything() if self._final else Share(processors() - 1, others_first=True)

    def _read(self) -> None:
        try:
            while True:
                self._note(self._connection.recv())
        except (EOFError, OSError):
            os._exit(1)  # nobody waits for a film any more

    def _note(self, message: Scenery | Order | Final) -> None:
        with self._changed:
            match message:
                case Scenery(obstacles):
                    self._obstacles = obstacles
                case Order():
                    self._newest = message
                case Final():
                    self._final = True
            self._changed.notify()


def work(connection: Connection) -> None:
    """Get ready, and draw what is ordered by a connection, newest first."""
    orders, number = OrderBook(connection), 0
    load()
    while True:
        order = orders.after(number)
        number = order.number
        result = _result(connection, order, orders)
        if result:
            connection.send(result)


def load() -> None:
    """Load all compiled loops of a film, by drawing nothing."""
    layers = [Solid(NO_FACETS), FloorPaint(NO_FACETS), Shadows([NO_FACETS.corners] * LIGHT_SAMPLES)]
    image = average(drawn(layers, (SMALL, SMALL), PAPER).color, 1)
    extent(NO_FACETS.corners, (SMALL, SMALL))
    reveal(blank((SMALL, SMALL), PAPER), NO_FACETS)
    shared_palette([image]).indices(image)


def _result(
    connection: Connection, order: Order, orders: OrderBook
) -> Drawn | DrawingFailed | None:
    """The film, or why there is none; None if a newer one is wanted instead."""
    try:
        with compilation(lambda one: connection.send(Compiling(one.functions, one.seconds))):
            with Crew(orders.share) as crew:
                film, parts = crew.do(staged, order.script), []
            for part in gif_parts(film, order.script.size, orders.share):
                if orders.beyond(order.number):
                    return None
                parts.append(part)
            return Drawn(order.number, b"".join(parts))
    except (BrokenPipeError, ConnectionResetError):
        raise  # nobody waits for it
    except MemoryError:
        return DrawingFailed(order.number, "", of_memory=True)
    except Exception:
        return DrawingFailed(order.number, traceback.format_exc(), of_memory=False)
