"""Whether values read from a file are what the fields of a record were declared to hold."""

from __future__ import annotations

import types
from functools import cache
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints


def check_fields(kind: type, values: dict[str, Any]) -> None:
    """Compare values with the annotations of a dataclass.

    Raises:
        TypeError: If one is of another type; the message says which.
    """
    for name, value in values.items():
        declared = _hints(kind).get(name, object)
        if not _fits(value, declared):
            raise TypeError(f"{name} of a {kind.__name__} is {str(value)[:60]}")


@cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _fits(value: Any, declared: Any) -> bool:
    """Whether a value is of a declared type; a whole number serves as a float."""
    origin, arguments = get_origin(declared), get_args(declared)
    if declared is Any:
        return True
    if origin in (Union, types.UnionType):
        return any(_fits(value, option) for option in arguments)
    if origin is Literal:
        return any(type(value) is type(option) and value == option for option in arguments)
    if origin is tuple:
        return isinstance(value, tuple) and _fit_entries(value, arguments)
    if declared in (int, float):
        return isinstance(value, (int, declared)) and not isinstance(value, bool)
    return isinstance(value, declared)


def _fit_entries(values: tuple[Any, ...], declared: tuple[Any, ...]) -> bool:
    if len(declared) == 2 and declared[1] is Ellipsis:
        return all(_fits(value, declared[0]) for value in values)
    return len(values) == len(declared) and all(map(_fits, values, declared))
