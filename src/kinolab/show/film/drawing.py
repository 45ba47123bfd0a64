"""The side of the process that draws films.

Only what draws is imported, no machine and no world. Orders are read between the parts of a film,
so that the final one, or the end of the process that sends them, is noticed while it is drawn.
Other orders wait until what was begun is finished: where better motions come faster than films,
there would be none.
"""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.connection import Connection

from kinolab.concurrency.processors import processors
from kinolab.numerics.compiling import compilation
from kinolab.show.film.crew import Crew, Share, everything
from kinolab.show.film.film import staged
from kinolab.show.film.film_messages import Compiling, Drawn, Final, Order
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.raster.draw_list import FloorPaint, Shadows, Solid, drawn
from kinolab.show.film.raster.light import LIGHT_SAMPLES
from kinolab.show.film.raster.rasterizer import NO_FACETS, average, blank, extent, reveal
from kinolab.show.film.staging.stage import PAPER
from kinolab.show.scene.picture import Surface

SMALL = 8  # [pixel] per side of the picture that is drawn beforehand


class OrderBook:
    """What is to be drawn, as it is told by the process that started this one.

    Raises:
        EOFError: By whatever reads, once nobody waits for a film any more.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._obstacles: Sequence[Surface] = ()
        self._newest: Order | None = None
        self._final = False

    def after(self, number: int) -> Order:
        """Wait for an order that is newer than the one with a number."""
        while not self.beyond(number):
            self._connection.poll(None)
        assert self._newest is not None
        picture = replace(self._newest.script.picture, obstacles=self._obstacles)
        return replace(self._newest, script=replace(self._newest.script, picture=picture))

    def beyond(self, number: int) -> bool:
        """Say whether there is a newer order than the one with a number."""
        self._read()
        return self._newest is not None and self._newest.number > number

    def replaces(self, number: int) -> bool:
        """Say whether a newer order than the one with a number is waited for."""
        return self.beyond(number) and self._final

    def share(self) -> Share:
        """What drawing may take: until the film is waited for, what the search leaves."""
        self._read()
        return everything() if self._final else Share(processors() - 1, others_first=True)

    def _read(self) -> None:
        while self._connection.poll():
            match self._connection.recv():
                case Order() as order:
                    self._newest = order
                    self._obstacles = order.script.picture.obstacles or self._obstacles
                case Final():
                    self._final = True


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
    average(drawn(layers, (SMALL, SMALL), PAPER).color, 1)
    extent(NO_FACETS.corners, (SMALL, SMALL))
    reveal(blank((SMALL, SMALL), PAPER), NO_FACETS)


def _result(connection: Connection, order: Order, orders: OrderBook) -> Drawn | None:
    """The film, or why there is none; None if a newer one is waited for instead."""
    try:
        with compilation(lambda one: connection.send(Compiling(one.functions, one.seconds))):
            with Crew(orders.share) as crew:
                film, parts = crew.do(staged, order.script), []
            for part in gif_parts(film, orders.share):
                if orders.replaces(order.number):
                    return None
                parts.append(part)
            return Drawn(order.number, b"".join(parts))
    except (BrokenPipeError, ConnectionResetError, EOFError):
        raise  # nobody waits for it
    except MemoryError:
        return Drawn(order.number, None)
    except Exception:
        return Drawn(order.number, None, traceback.format_exc())
