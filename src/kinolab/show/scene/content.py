"""Content of an interactive page, independent of HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from kinolab.numerics.arrays import Array
from kinolab.show.scene.picture import Picture


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise cubic Hermite curve over time.

    Rates may jump at keys, as inputs do, so every key has one before and one after it.

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
        turns: Of every body, as unit quaternions x, y, z, w, d = 4; values between keys must be
            normalized.
        ends: Of all cables in [m], d = 6 for each of them; None if there is no cable.
        joints: The joints' frames, likewise.
    """

    places: Sequence[Curve]
    turns: Sequence[Curve]
    ends: Curve | None = None
    joints: Keys | None = None


@dataclass(frozen=True, eq=False)
class Series:
    """Quantities over time, drawn as one plot each.

    Attributes:
        title: Title of the group, such as ``Inputs``.
        names: One per column.
        units: One per column; empty if dimensionless.
        values: At the knots, shape (N+1, n), or between them, shape (N, n).
        held: Whether values are held from knot to knot (zero-order hold).
        limits: Of each column: the least, the largest, and whose limits these are; none are known
            where it is empty.
        first: Columns that are shown at first; some that have a unit where it is None.
    """

    title: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    held: bool = False
    limits: tuple[tuple[float, float, str], ...] = ()
    first: tuple[int, ...] | None = None


@dataclass(frozen=True, eq=False)
class Driving:
    """The machine for interactive simulation in the page.

    Attributes:
        code: A JavaScript expression, as returned by ``javascript_of``.
        states: Stored states of the plan, from which driving may start, shape (N+1, nx).
        facts: Plain data for the page's ``drive.js``: start, step, limits, idle inputs.
    """

    code: str
    states: Array
    facts: Mapping[str, Any]


@dataclass(frozen=True, eq=False, kw_only=True)
class Content:
    """Everything on a page.

    Attributes:
        title: Title of the page.
        name: Name of the scenario.
        machine: Name of the system.
        picture: World, machine, start and goal.
        keys: The motion; a single key if nothing moves.
        joints: Names of the joints' frames.
        leading: The body whose path is drawn first.
        knots: Times of the stored states in [s], shape (N+1,).
        series: Plotted quantities.
        constraints: Names of the constraints.
        facts: Facts about the plan, by the keys of a report; empty before planning.
        speed: Initial playback speed: seconds of motion per second.
        tree: Segments of the search tree in [m], shape (n, 2, 3); None if it was not stored.
        driving: The machine for interactive simulation; None without it.
        posing: Plain data for the page's ``posing.js``: coordinates with their ranges; None where a
            motion is shown.
        live: Address of the live search's events, seen from the page; None for a file.
    """

    title: str
    name: str
    machine: str
    picture: Picture
    keys: Keys
    knots: Array
    joints: Sequence[str] = ()
    leading: int = 0
    series: Sequence[Series] = ()
    constraints: Sequence[str] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    speed: float = 1.0
    tree: Array | None = None
    driving: Driving | None = None
    posing: Mapping[str, Any] | None = None
    live: str | None = None
