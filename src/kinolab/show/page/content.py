"""What an interactive page shows, said without a word of HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from kinolab.numerics.arrays import Array
from kinolab.show.film.picture import Picture


@dataclass(frozen=True, eq=False)
class Curve:
    """Something that changes with time: a cubic between every two of its keys.

    Rates may jump where inputs do, so that every key has one before and one after it.

    Attributes:
        times: Of the keys in [s], shape (nk,), increasing.
        values: At the keys, shape (nk, d).
        arriving: Rates of change just before each key, shape (nk, d).
        leaving: Rates of change just after each key, shape (nk, d).
    """

    times: Array
    values: Array
    arriving: Array
    leaving: Array


@dataclass(frozen=True, eq=False)
class Keys:
    """A motion as curves, one or more keys each.

    Attributes:
        places: Of every body's origin in [m], d = 3.
        turns: Of every body, as unit quaternions x, y, z, w, d = 4; what lies between two keys has
            to be divided by its norm.
        ends: Of all cables in [m], d = 6 for each of them; None where there is no cable.
    """

    places: Sequence[Curve]
    turns: Sequence[Curve]
    ends: Curve | None = None


@dataclass(frozen=True, eq=False)
class Series:
    """Quantities over time, drawn as one plot each.

    Attributes:
        title: What they are together, such as ``Inputs``.
        names: One per column.
        units: One per column; empty where there is none.
        values: At the knots, shape (N+1, n), or between them, shape (N, n).
        held: Whether a value lasts from its knot to the next.
    """

    title: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    held: bool = False


@dataclass(frozen=True, eq=False)
class Driving:
    """The machine to be simulated by the page itself.

    Attributes:
        code: An expression of JavaScript, as ``javascript_of`` returns it.
        states: Stored states of the plan, from which one may go on, shape (N+1, nx).
        facts: Plain data for the page's ``drive.js``: start, step, limits, inputs without a push.
    """

    code: str
    states: Array
    facts: Mapping[str, Any]


@dataclass(frozen=True, eq=False, kw_only=True)
class Content:
    """Everything on a page.

    Attributes:
        title: Of the page.
        name: Of the scenario.
        machine: Name of the system.
        picture: World, machine, start and goal.
        keys: The motion; a single key where nothing moves.
        knots: Times of the stored states in [s], shape (N+1,).
        series: What is plotted.
        constraints: Names of what is held at zero.
        facts: What is told about the plan, by the names of a report's keys; empty before planning.
        speed: Seconds of motion per second at first.
        tree: Segments of the search tree in [m], shape (n, 2, 3), None where nobody kept it.
        driving: The machine for the page to simulate; None where nobody shall drive it.
        live: Where the page's own server tells how a search goes; None for a page that is a file.
    """

    title: str
    name: str
    machine: str
    picture: Picture
    keys: Keys
    knots: Array
    series: Sequence[Series] = ()
    constraints: Sequence[str] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    speed: float = 1.0
    tree: Array | None = None
    driving: Driving | None = None
    live: str | None = None
