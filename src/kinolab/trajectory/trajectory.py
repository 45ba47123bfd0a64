"""Trajectories: states at knots, zero-order-hold inputs and feedback references."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinolab.arguments import require_fit
from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.files import write_whole
from kinolab.numerics.arrays import Array
from kinolab.trajectory.interpolation import states_at
from kinolab.untrusted import text_file, why


class Moment(NamedTuple):
    """A motion at one time, or at several, one row for each.

    Attributes:
        t: Times in [s], shape () or (m,).
        x: States, shape (nx,) or (m, nx).
        u: Inputs that act, shape (nu,) or (m, nu); at the end those of the last interval.
        references: Set points of the machine's feedback, likewise.
    """

    t: Array
    x: Array
    u: Array
    references: Array


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """States over time with piecewise constant inputs.

    Attributes:
        t: Times of the knots in [s], shape (N+1,), increasing from 0.
        x: States at the knots, shape (N+1, nx); angles are continuous, not wrapped.
        u: Inputs held from each knot to the next, shape (N, nu).
        state_names: Names of the columns of ``x``.
        control_names: Names of the columns of ``u``.
        references: Set points of the machine's feedback, held likewise, shape (N, nr); no columns
            without feedback.
        reference_names: Names of the columns of ``references``.
    """

    t: Array
    x: Array
    u: Array
    state_names: tuple[str, ...]
    control_names: tuple[str, ...]
    references: Array = field(default_factory=lambda: np.zeros((0, 0)))
    reference_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Reject arrays of inconsistent shapes."""
        if not self.reference_names and not self.references.size:
            object.__setattr__(self, "references", np.zeros((len(self.u), 0)))
        rows, steps = len(self.t), max(len(self.t) - 1, 0)
        shapes = {
            "t": (self.t.shape, (rows,)),
            "x": (self.x.shape, (rows, len(self.state_names))),
            "u": (self.u.shape, (steps, len(self.control_names))),
            "references": (self.references.shape, (steps, len(self.reference_names))),
        }
        mistakes = [
            Mistake("trajectory", f"{name} has shape {found}; it must be {wanted}.")
            for name, (found, wanted) in shapes.items()
            if found != wanted
        ]
        if rows == 0:
            mistakes.append(Mistake("trajectory", "it has no knots."))
        if mistakes:
            raise InputError(mistakes)

    @property
    def duration(self) -> float:
        """Duration in [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def inputs(self) -> Array:
        """The planned inputs: references if the machine has feedback, else ``u``."""
        return self.references if self.reference_names else self.u

    def __repr__(self) -> str:
        """Say how long it is and what it is made of."""
        names = ", ".join(self.state_names)
        return f"<Trajectory of {self.duration:.2f} s, {len(self.t)} knots of {names}>"

    def at(self, t: ArrayLike) -> Moment:
        """Return the motion at a time, or at each of several: ``trajectory.at(1.5).x``.

        Inputs are held from each knot to the next. States between knots are interpolated from what
        is stored, by cubics where the rate of a coordinate is a state, else along chords; what is
        true there, ``verify`` and the page integrate.

        Args:
            t: In [s], shape () or (m,).

        Raises:
            InputError: If a time is before the first knot or after the last one.
        """
        require_fit("at t", float if np.ndim(t) == 0 else ArrayLike, t)
        times = np.atleast_1d(np.asarray(t, dtype=float))
        first, last = float(self.t[0]), float(self.t[-1])
        if times.ndim != 1 or not ((times >= first) & (times <= last)).all():
            outside = times[~((times >= first) & (times <= last))]
            what = "times are one number or a list of them."
            if outside.size:
                what = f"{float(outside.flat[0]):g} s is outside the motion."
            raise InputError([Mistake("at t", what, f"Give times from {first:g} to {last:g} s.")])
        x = states_at(self.t, self.x, self.state_names, times)
        k = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, max(len(self.u) - 1, 0))
        u, references = (
            held[k] if len(held) else np.full((len(k), held.shape[1]), np.nan)
            for held in (self.u, self.references)
        )
        row: Any = 0 if np.ndim(t) == 0 else slice(None)
        return Moment(times[row], x[row], u[row], references[row])

    def piece(self, begin: int, end: int) -> Trajectory:
        """Return the segment between two knots, by index, with times from 0."""
        t, held = self.t[begin : end + 1] - self.t[begin], slice(begin, end)
        x, references = self.x[begin : end + 1], self.references[held]
        return replace(self, t=t, x=x, u=self.u[held], references=references)

    def with_piece(self, begin: int, end: int, other: Trajectory, space: StateSpace) -> Trajectory:
        """Return the trajectory with a segment replaced, possibly by one of another duration.

        The rest continues from its end: entries that may end differently are shifted by the
        difference, and quaternions keep their sign.

        Args:
            begin: First knot of the segment.
            end: Last knot of the segment.
            other: The new segment, from and to the same states as far as the dynamics depend on
                them.
        """
        own = self.t[begin] + other.t - other.t[0]
        rest = own[-1] + self.t[end + 1 :] - self.t[end]
        carried = space.carried(self.x[end:], other.x[-1])
        return replace(
            self,
            t=np.concatenate([self.t[:begin], own, rest]),
            x=np.vstack([self.x[:begin], other.x[:-1], carried]),
            u=np.vstack([self.u[:begin], other.u, self.u[end:]]),
            references=np.vstack(
                [self.references[:begin], other.references, self.references[end:]]
            ),
        )

    def to_dataframe(self, library: Literal["pandas", "polars"] | None = None) -> Any:
        """Return a data frame with the columns of ``trajectory.csv``; the last inputs are NaN.

        Args:
            library: Whose; when left out, pandas' or else Polars', whichever is installed.

        Raises:
            InputError: If it is not installed.
        """
        known = ("pandas", "polars")
        if library not in (None, *known):
            raise UnknownNameError("library", str(library), known=known, where="to_dataframe")
        for name in (library,) if library else known:
            try:
                return import_module(name).DataFrame(self._columns())
            except ImportError:
                continue
        absent = f"{library} is" if library else "pandas is not installed, and polars is"
        package = "polars" if library == "polars" else "'kinolab[tables]'"
        remedy = f"pip install {package}, or write to_csv(path)."
        raise InputError([Mistake("to_dataframe", f"{absent} not installed.", remedy)])

    def _columns(self) -> dict[str, Array]:
        """Return the columns of ``trajectory.csv`` by name, each of shape (N+1,)."""
        held = np.hstack([self.u, self.references])
        held = np.vstack([held, np.full((1, held.shape[1]), np.nan)])
        names = _header(self.state_names, self.control_names, self.reference_names)
        return dict(zip(names, np.column_stack([self.t, self.x, held]).T, strict=True))

    def to_csv(self, path: str | Path | None = None) -> str:
        """Return the content of ``trajectory.csv``, and write it; the last row has no inputs.

        Args:
            path: Of the file, which is written whole or not at all; left out, none is written.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(_header(self.state_names, self.control_names, self.reference_names))
        held_rows, width = np.hstack([self.u, self.references]), len(self.control_names)
        blank = [""] * (width + len(self.reference_names))
        for k, (time, state) in enumerate(zip(self.t, self.x, strict=True)):
            held = map(_digits, held_rows[k]) if k < len(held_rows) else blank
            writer.writerow([_digits(time), *map(_digits, state), *held])
        if path is not None:
            require_fit("to_csv path", str | Path, path)
            write_whole(Path(path), out.getvalue().encode())
        return out.getvalue()

    def to_npz(self) -> bytes:
        """Return the content of ``trajectory.npz``."""
        out = io.BytesIO()
        tables: dict[str, Any] = {
            "t": self.t,
            "x": self.x,
            "u": self.u,
            "state_names": np.array(self.state_names, dtype=str),
            "control_names": np.array(self.control_names, dtype=str),
        }
        if self.reference_names:
            tables["references"] = self.references
            tables["reference_names"] = np.array(self.reference_names, dtype=str)
        np.savez(out, **tables)
        return out.getvalue()


def read_csv(
    path: Path,
    state_names: tuple[str, ...],
    control_names: tuple[str, ...],
    reference_names: tuple[str, ...] = (),
) -> Trajectory:
    """Read ``trajectory.csv`` of a machine whose states, inputs and references have these names.

    Raises:
        InputError: With line and column, if the header or a value is invalid.
    """
    header = _header(state_names, control_names, reference_names)
    try:
        lines = csv.reader(io.StringIO(text_file(path)))
        if next(lines, None) != header:
            what = f"its header is not {','.join(header)}."
            raise InputError([Mistake(f"{path} line 1", what)])
        rows = _rows(lines, len(header))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError([Mistake(str(path), f"it cannot be read ({why(error)}).")]) from error
    if not rows:
        raise InputError([Mistake(str(path), "it has no knots.")])
    data = _numbers(path, rows, header, 1 + len(state_names))
    nx, nu = len(state_names), len(control_names)
    return Trajectory(
        t=data[:, 0],
        x=data[:, 1 : 1 + nx],
        u=data[:-1, 1 + nx : 1 + nx + nu],
        state_names=state_names,
        control_names=control_names,
        references=data[:-1, 1 + nx + nu :],
        reference_names=reference_names,
    )


def _header(states: Sequence[str], controls: Sequence[str], references: Sequence[str]) -> list[str]:
    return ["t", *states, *controls, *map(reference_column, references)]


def reference_column(name: str) -> str:
    """Return the column name of a reference in the files of a run."""
    return f"reference.{name}"


def _rows(lines: Iterable[list[str]], width: int) -> list[list[str]]:
    """Return the rows below a header, up to the tenth of another width: ten mistakes are told."""
    rows: list[list[str]] = []
    others = 0
    for row in lines:
        if len(rows) == 100_000:  # steps of 10 ms for a quarter of an hour
            raise csv.Error("it has more than 100000 knots")
        rows.append(row)
        others += len(row) != width
        if others == 10:
            break
    return rows


def _numbers(path: Path, rows: list[list[str]], header: Sequence[str], states: int) -> Array:
    """Parse rows; only the last one has no inputs."""
    width = len(header)
    data = np.full((len(rows), width), np.nan)
    mistakes: list[Mistake] = []
    for k, row in enumerate(rows):
        if len(mistakes) >= 10:
            break
        needed = states if k == len(rows) - 1 else width
        where = f"{path} line {k + 2}"
        if len(row) != width:
            mistakes.append(Mistake(where, f"{len(row)} values where {width} are due."))
            continue
        for column, text in enumerate(row):
            try:
                if column < needed:
                    data[k, column] = _number(text)
                elif text:
                    raise ValueError(f"{text!r} is an input in the last row, which has none")
            except ValueError as error:
                mistakes.append(Mistake(f"{where} column {header[column]}", f"{error}."))
    if mistakes:
        raise InputError(mistakes[:10])
    return data


def _number(text: str) -> float:
    try:
        if not text.isascii() or "_" in text:  # which Python reads as numbers, and few others do
            raise ValueError
        value = float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise ValueError(f"{text} is not finite")
    return value


def _digits(value: float) -> str:
    """Format a double so that it is read back exactly."""
    return repr(float(value))
