"""Run-time checks of public functions' arguments against their type annotations.

``@checked`` decorates a function or a dataclass. A mismatch raises an input error that names the
function, the argument and what would fit, for all arguments at once. Only types are checked; values
(limits, units, names that exist) are validated where they are used.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache, wraps
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.errors import InputError, Mistake, meant

F = TypeVar("F", bound=Callable[..., Any])

PHRASES = {
    "Attitude": "an attitude of rotation(…)",
    "Axis": "an axis of a frame, such as fork.z",
    "Shape": "a Box or a Sphere or a Cylinder or a Capsule or a Disk",
    "Effort": "a force, such as Viscous(rate(x), 0.1)",
    "InputSymbol": "the symbol of an input",
    "ReferenceSymbol": "the symbol of a reference",
    "Input": 'an input, such as Control("u", limit=1)',
    "Coordinate": "a coordinate of length(…) or angle(…)",
    "Expr": "an expression of the machine's symbols",
    "Frame": "a frame, such as move(x, y) @ rot_z(psi)",
    "Gravity": 'what toward("-z") returns',
    "MutableDenseMatrix": "a SymPy matrix",
    "Mechanism": "a System",
    "Model": "a model, such as system.model()",
    "Parameter": "a parameter(…)",
    "Path": "a path",
    "PlanResult": "a plan of problem.solve(…)",
    "PlanningTask": "a problem of kinolab.load(…)",
    "PositionConstraint": "a constraint of closed(…)",
    "Requirement": "a requirement of require(…)",
    "Run": "a run of kinolab.read_run(…)",
    "Symbol": "a symbol",
    "Trajectory": "a trajectory",
    "VectorFields": "the vector_fields(…) of a system",
    "VelocityConstraint": "a constraint of zero(…)",
    "bool": "True or False",
    "float": "a number",
    "int": "a whole number",
    "ndarray": "an array of numbers",
    "str": "a text",
}


def checked(thing: F) -> F:
    """Check the arguments of a function, or of a class's constructor, before it runs.

    Raises:
        InputError: On a call, naming each argument that does not match its annotation.
    """
    if inspect.isclass(thing):
        own = "__new__" if "__new__" in vars(thing) else "__init__"
        made = _checking(getattr(thing, own), "", skipped=1)
        setattr(thing, own, staticmethod(made) if own == "__new__" else made)
        return thing
    name = thing.__qualname__
    bound = name.rpartition(".")[0] not in ("", "<locals>")
    return _checking(thing, name, skipped=int(bound))  # type: ignore[return-value]


def require_fit(where: str, hint: Any, value: object) -> None:
    """Check one value against a type that a module imports late.

    Args:
        where: What a mistake is reported for.
        hint: The type, as an annotation would give it.
        value: What was given.

    Raises:
        InputError: If it does not match.
    """
    if not _fits(hint, value):
        raise InputError([_mistake(where, hint, value)])


def _checking(function: Callable[..., Any], name: str, skipped: int) -> Callable[..., Any]:
    """Wrap a function with argument checks; without a name, errors name its class."""
    signature = inspect.signature(function)

    @wraps(function)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        try:
            given = signature.bind(*args, **kwargs)
        except TypeError:
            _require_known(name or type(args[0]).__name__, signature, kwargs)
            return function(*args, **kwargs)  # Python reports what is missing, or twice there
        own = list(given.arguments)[:skipped]
        values = {key: value for key, value in given.arguments.items() if key not in own}
        # a class's name: of the instance, or the class itself in ``__new__``
        where = name or (args[0] if inspect.isclass(args[0]) else type(args[0])).__name__
        if isinstance(called := values.get("name"), str):  # the user's name for the object
            where = f"{where} {called!r}"
        hints = _hints(function, bool(_of_sympy("Basic")))
        mistakes = [
            _mistake(f"{where} {key}", hint, value)
            for key, value in values.items()
            if not _fits(hint := hints.get(key, Any), value)
        ]
        if mistakes:
            raise InputError(mistakes)
        return function(*args, **kwargs)

    return wrapper


def _require_known(name: str, signature: inspect.Signature, given: Mapping[str, Any]) -> None:
    """Raise as Python does where an argument has no such name, and suggest one that there is."""
    known = signature.parameters
    if any(one.kind is inspect.Parameter.VAR_KEYWORD for one in known.values()):
        return
    for unknown in given:
        if unknown not in known:
            called = name.rpartition(".")[2]
            what = f"{called}() got an unexpected keyword argument {unknown!r}."
            raise TypeError(f"{what} {meant(unknown, known)}".rstrip())


class _NotImported:
    """Stands for SymPy in annotations while nothing has imported it: no value is of its classes."""

    def __getattr__(self, name: str) -> type:
        return type(name, (), {})


def _of_sympy(name: str) -> tuple[Any, ...]:
    """Return a class of SymPy's in a tuple; none while nothing has imported SymPy."""
    found = getattr(sys.modules.get("sympy"), name, None)
    return () if found is None else (found,)


@cache
def _hints(function: Callable[..., Any], symbolic: bool) -> dict[str, Any]:
    own = {"sympy": sys.modules["sympy"] if symbolic else _NotImported()}
    hints = get_type_hints(function, localns=own)
    variadic = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    kinds = inspect.signature(function).parameters
    return {
        key: hint
        for key, hint in hints.items()
        if kinds.get(key) and kinds[key].kind not in variadic
    }


def shown(value: Any) -> str:
    """Return a value as a message quotes it."""
    return text if len(text := repr(value)) <= 60 else f"a {type(value).__name__}"


def _mistake(where: str, hint: Any, value: Any) -> Mistake:
    """Describe the mismatch; in a collection, the entry at fault."""
    inner = get_args(hint)
    if _is_collection_of(hint) and _is_collection(value):
        entries = enumerate(value, start=1)
        k, wrong = next((k, entry) for k, entry in entries if not _fits(inner[0], entry))
        return _mistake(f"{where} entry {k}", inner[0], wrong)
    table = next((one for one in (hint, *inner) if _is_table_of(one)), None)
    if table is not None and isinstance(value, Mapping):
        return _entry_mistake(where, get_args(table), value)
    phrases = " or ".join(dict.fromkeys(_phrases(hint)))
    return Mistake(where, f"it is {shown(value)}.", f"Give {phrases}.")


def _entry_mistake(where: str, kinds: tuple[Any, ...], table: Mapping[Any, Any]) -> Mistake:
    """Describe the first entry of a table whose key or value does not match."""
    for key, value in table.items():
        if not _fits(kinds[0], key):
            return _mistake(f"{where} key {shown(key)}", kinds[0], key)
        if not _fits(kinds[1], value):
            return _mistake(f"{where} entry {shown(key)}", kinds[1], value)
    raise AssertionError("a table is wrong in one of its entries")


def _origin(hint: Any) -> Any:
    """Return the generic type of an annotation, or of what it names, as NumPy 2.5 names arrays."""
    origin = get_origin(hint)
    named = getattr(origin, "__value__", origin)
    return get_origin(named) or named


def _is_table_of(hint: Any) -> bool:
    origin = _origin(hint)
    return inspect.isclass(origin) and issubclass(origin, Mapping)


def _is_collection_of(hint: Any) -> bool:
    """Whether an annotation is of a list, or similar, of any length."""
    origin = _origin(hint)
    several = inspect.isclass(origin) and issubclass(origin, Collection) and origin is not tuple
    return several and not issubclass(origin, Mapping | np.ndarray)


def _is_collection(value: Any) -> bool:
    return isinstance(value, Collection) and not isinstance(value, str | bytes | Mapping)


def _fits(hint: Any, value: Any) -> bool:
    origin, inner = _origin(hint), get_args(hint)
    if hint is Any:
        return True
    if hint == ArrayLike or np.ndarray in (hint, origin):
        return _is_array(value)
    if origin in (Union, UnionType):
        symbolic = any(inspect.isclass(a) and issubclass(a, _of_sympy("Basic")) for a in inner)
        if symbolic and _is_real(value) and not math.isfinite(value):
            return False  # nan is no valid expression
        return any(_fits(argument, value) for argument in inner)
    if origin is Literal:
        return isinstance(value, type(inner[0]))  # unknown names have an error of their own
    if origin is tuple:
        if isinstance(value, tuple) and inner[1:] == (Ellipsis,):
            inner = inner[:1] * len(value)
        sized = isinstance(value, tuple) and len(value) == len(inner)
        return sized and all(map(_fits, inner, value))
    if _is_table_of(hint):
        return isinstance(value, Mapping) and all(
            _fits(inner[0], key) and _fits(inner[1], entry) for key, entry in value.items()
        )
    if _is_collection_of(hint):
        return _is_collection(value) and all(_fits(inner[0], entry) for entry in value)
    return _fits_class(hint, value)


def _fits_class(hint: Any, value: Any) -> bool:
    if hint in (None, NoneType):
        return value is None
    if hint is bool:
        return isinstance(value, bool | np.bool_)
    if hint is int:
        return isinstance(value, Integral) and not isinstance(value, bool)
    if hint is float:
        return _is_real(value) or _is_constant(value)
    if inspect.isclass(hint) and issubclass(hint, matrices := _of_sympy("MatrixBase")):
        return isinstance(value, matrices)  # mutable or not
    return isinstance(value, hint) if inspect.isclass(hint) else True


def _is_real(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_constant(value: Any) -> bool:
    """Whether an expression is a number, such as pi / 3."""
    return isinstance(value, _of_sympy("Expr")) and bool(value.is_number and value.is_extended_real)


def _is_array(value: Any) -> bool:
    """Whether a value is an array of at least one dimension."""
    try:
        array = np.asarray(value)
    except ValueError:  # ragged rows
        return False
    return array.ndim > 0 and (array.dtype.kind in "iuf" or not array.size)


def _phrases(hint: Any) -> Iterator[str]:
    """Yield descriptions of an annotation, in words."""
    origin, inner = _origin(hint), get_args(hint)
    if hint == ArrayLike or origin is np.ndarray:
        yield PHRASES["ndarray"]
    elif origin in (Union, UnionType):
        tables = any(map(_is_table_of, inner))
        for argument in inner:
            if tables and get_origin(argument) in (tuple, Sequence):
                continue  # of pairs: the same as a table, in another way
            if argument is not NoneType and not (argument is int and float in inner):
                yield from _phrases(argument)
    elif origin is Literal:
        yield " or ".join(map(repr, inner))
    elif origin is tuple and not (len(inner) == 2 and inner[1] is Ellipsis):
        words = [" or ".join(dict.fromkeys(_phrases(argument))) for argument in inner]
        alike = len(set(words)) == 1
        yield f"a tuple of {len(words)}, each {words[0]}" if alike else f"({', '.join(words)})"
    elif _is_table_of(hint):
        key, value = (" or ".join(dict.fromkeys(_phrases(argument))) for argument in inner)
        yield f"a table {{key: value, …}}, each key {key}, each value {value}"
    elif origin is not None:
        kind = "tuple" if origin is tuple else "list"
        entry = " or ".join(dict.fromkeys(_phrases(inner[0])))
        if kind == "tuple" and entry.startswith("(") and len(get_args(inner[0])) == 2:
            yield f"a tuple of pairs {entry}; of a single one ({entry},)"
        else:
            yield f"a {kind}, each entry {entry}"
    else:
        name = getattr(hint, "__name__", str(hint))
        yield PHRASES.get(name, f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}")


def require_numbers(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return finite numbers as an array of a shape.

    Raises:
        InputError: If they are something else.
    """
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        what = f"it is {type(values).__name__}, and not made of numbers."
        raise InputError([Mistake(name, what, f"Give an array of shape {shape}.")]) from None
    if found.shape != shape or not np.isfinite(found).all():
        what = "it has a number that is not finite."
        if found.shape != shape:
            what = f"it has shape {found.shape}; it must be {shape}."
        raise InputError([Mistake(name, what, f"Give finite numbers of shape {shape}.")])
    return np.ascontiguousarray(found)
