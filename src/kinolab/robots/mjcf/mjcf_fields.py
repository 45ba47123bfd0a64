"""What of MuJoCo's compiled model is read, and what may be passed over; anything else is told.

Every field of ``mjModel`` and ``mjOption`` is read, has no effect where nothing touches, or must be
neutral. One that a later MuJoCo adds is in no table, and must be zero.

Source: MuJoCo's documentation, chapter Computation; mjmodel.h.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

TABLES = tomllib.loads(files(__package__).joinpath("mjcf_fields.toml").read_text("utf-8"))
SPELLED, ELEMENTS, FLAGS = TABLES["spelled"], TABLES["elements"], TABLES["flags"]
READ, WITHOUT_EFFECT = (
    frozenset(f"{prefix}{name}" for prefix, names in TABLES[key].items() for name in names.split())
    for key in ("read", "without_effect")
)
REASONS = {begin: why for why, begins in TABLES["reasons"].items() for begin in begins.split()}
# Whole elements; flexes, plugins and height fields are refused where they are used.
ELEMENTS_WITHOUT_EFFECT = re.compile(
    "(bvh|oct|cam|light|tex|mat|mesh|skin|hfield|sensor|numeric|text|tuple|key|name|exclude|wrap"
    "|tree|plugin|flex|flexedge|B|C|D|M|efm0|efmC)_.*|map.2.|n[a-zA-Z0-9_]*"
)
NONE = -1  # of an address or number: there is none
NEUTRAL = {"body_plugin": NONE, "geom_plugin": NONE, "actuator_plugin": NONE}


def disabled(mujoco: Any, model: Any) -> set[str]:
    """Return the flags that a model disables, those that others imply, too."""
    flags = int(model.opt.disableflags)
    found = {
        name.removeprefix("mjDSBL_")
        for name, bit in mujoco.mjtDisableBit.__members__.items()
        if name.startswith("mjDSBL_") and flags & int(bit)
    }
    # of the flag "constraint"
    return found | {"EQUALITY", "FRICTIONLOSS", "LIMIT"} if "CONSTRAINT" in found else found


def apply_flags(mujoco: Any, model: Any) -> None:
    """Set to nothing what a model's flags disable."""
    for flag in disabled(mujoco, model) & FLAGS.keys():
        for name in FLAGS[flag].split():
            values = _value(model, name)
            if values is not None:
                values[...] = 0


def unknown_flags(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of flags that are in no table."""
    further = TABLES["other_flags"]
    kinds = {
        "disable": (mujoco.mjtDisableBit, "mjDSBL_", f"{' '.join(FLAGS)} {further['disable']}"),
        "enable": (mujoco.mjtEnableBit, "mjENBL_", further["enable"]),
    }
    for word, (bits, prefix, known) in kinds.items():
        flags = int(getattr(model.opt, f"{word}flags"))
        for name, bit in bits.__members__.items():
            flag = name.removeprefix(prefix)
            if name.startswith(prefix) and flags & int(bit) and flag not in known.split():
                yield f'the flag {flag.lower()}="{word}" has no counterpart.'


def not_looked_at(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of fields that are not read and differ from their neutral values."""
    for name in _fields(model):
        known = name in READ | WITHOUT_EFFECT or ELEMENTS_WITHOUT_EFFECT.fullmatch(name)
        if not known:
            values = _rows(model, name)
            wrong = np.any(values != NEUTRAL.get(name, 0), axis=1)
            yield from _told(mujoco, model, name, values, wrong)
    for k in range(model.nflex):
        yield f"flex {element_name(mujoco, model, 'FLEX', k)} is deformable."


def not_finite(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield what is said of fields that are read and have no finite values, and of empty ranges.

    MuJoCo itself passes over a range whose end is below its beginning.
    """
    for name in _fields(model):
        if name not in READ:
            continue
        values = _rows(model, name)
        wrong = np.any(~np.isfinite(values), axis=1)
        yield from _told(mujoco, model, name, values, wrong, "is not finite")
        if name.endswith("range"):
            wrong = values[:, 0] > values[:, 1]
            yield from _told(mujoco, model, name, values, wrong, "ends below where it begins")


def element_name(mujoco: Any, model: Any, kind: str, k: int) -> str:
    """Return the name of an element of a type such as ``"JOINT"``, or its number from 1 on."""
    name = mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), k)
    return str(name or k + 1)


def _told(
    mujoco: Any,
    model: Any,
    name: str,
    rows: Array,
    wrong: NDArray[np.bool_],
    why: str | None = None,
) -> Iterator[str]:
    """Yield an element's attribute and its value, for the first elements of which it is wrong."""
    prefix, _, rest = name.partition("_")
    attribute = SPELLED.get(name, rest or name)
    reasons = (said for begins, said in REASONS.items() if name.startswith(begins))
    why = why or next(reasons, "has no counterpart")
    if name.endswith("_limited"):  # it is more telling to show the range
        rows = _rows(model, name.replace("_limited", "_range"))
    for k in islice(np.flatnonzero(wrong).tolist(), 3):  # elements of which one message tells
        values = " ".join(f"{float(value):g}" for value in rows[k][:6])
        if prefix == "opt":
            yield f"option {attribute} is {values}, which {why}."
        elif prefix in ELEMENTS and len(rows) == _count(model, prefix):
            at = int(model.dof_jntid[k]) if prefix == "dof" else k
            kind = ELEMENTS[prefix]
            who = f"{kind.lower()} {element_name(mujoco, model, kind, at)}"
            yield f"{who} has {attribute} {values}, which {why}."
        else:
            yield f"its {attribute} is {values}, which {why}."


def _count(model: Any, prefix: str) -> int:
    counts = {"dof": "nv", "eq": "neq", "actuator": "nactuator"}
    return int(getattr(model, counts.get(prefix, f"n{prefix}"), model.nu))


def _fields(model: Any) -> Iterator[str]:
    """Yield the names of the fields of a model, then of its options, as opt_name."""
    for prefix, whole in (("", model), ("opt_", model.opt)):
        for name in dir(whole):
            if not name.startswith("_") and not callable(getattr(whole, name)):
                yield prefix + name


def _value(model: Any, name: str) -> Any:
    """Return a field of a model or, as opt_name, of its options; None before MuJoCo had it."""
    owner, own = (model.opt, name[4:]) if name.startswith("opt_") else (model, name)
    return getattr(owner, own, None)


def _rows(model: Any, name: str) -> Array:
    """Return a field's values, one row for each element."""
    values = np.asarray(_value(model, name))
    if values.dtype.kind not in "biuf":  # what has no number says something
        return np.ones((1, 1))
    single = values.ndim == 0 or name.startswith("opt_")
    shape = (1, values.size) if single else (len(values), math.prod(values.shape[1:]))
    return values.astype(np.float64).reshape(shape)
