"""The file of a study: what is run, how often, with which settings and within which limits."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails

from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.scenario.file_lookup import read_text
from kinolab.scenario.load import toml_document
from kinolab.scenario.locations import fields_of, model_in
from kinolab.scenario.toml_text import key_text, shown

LARGEST_SEED = 2**63 - 1  # the largest that tables hold
NAMED_ELSEWHERE = {  # keys of a scenario that a study names by keys of its own
    "planner.name": "List planners under planners.",
    "planner.seed": "Give seeds.",
    "planner.time_limit": "Give [limits] search.",
    "planner.max_iterations": "Give [limits] iterations.",
    "system.name": "List scenarios under scenarios.",
    "system.file": "List scenarios under scenarios.",
    "planner": "Give its keys, such as planner.goal_bias.",
    "system": "Give its keys, such as system.parameters.",
}

Positive = Annotated[float, Field(gt=0.0)]


def _finite(held: Any) -> Any:
    """Refuse lists and tables that hold numbers which are not finite."""
    inside = held.values() if isinstance(held, dict) else held
    for value in inside if isinstance(held, dict | list) else ():
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError("it holds a number that is not finite")
        _finite(value)
    return held


Holder = Annotated[list[Any] | dict[str, Any], AfterValidator(_finite)]
Value = bool | int | float | str | Holder


class Table(BaseModel):
    """What all tables share: strict types, finite numbers, no unknown keys, no changes."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
    )


class Limits(Table):
    """``[limits]``: of each run; what is left out is not limited, or as the scenario says."""

    search: Positive | None = None
    """Processor time of a search, in s, above 0; else the scenario's limit."""
    iterations: Annotated[int, Field(gt=0, le=LARGEST_SEED)] | None = None
    """Iterations of a search, 1 or more; else the scenario's limit."""
    cpu: Positive | None = None
    """Processor time of a run, in s, above 0; it ends there."""
    memory: Positive | None = None
    """Memory of a run, in MB, above 0; it ends there."""


class Range(Table):
    """Between which values a Sobol sequence varies a key."""

    low: float = Field(alias="from")
    """Lowest value."""
    high: float = Field(alias="to")
    """Highest value."""
    scale: Literal["linear", "log"] = "linear"
    """"linear" or "log": how values are spread between them."""
    whole: bool = False
    """true or false: whether values are rounded to whole numbers."""

    @model_validator(mode="after")
    def _sensible(self) -> Range:
        if self.low >= self.high:
            raise ValueError("its from is not below its to")
        if not math.isfinite(self.high - self.low):
            raise ValueError("it is wider than numbers reach")
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError("a logarithmic scale needs values above 0")
        return self


class Sobol(Table):
    """``[sobol]``: points of a Sobol sequence in the ranges of several keys."""

    points: int = Field(gt=0, le=65_536)  # of a Sobol sequence
    """How many; a power of 2 is best."""
    seed: int = Field(default=1, ge=0)
    """Of the scrambling."""
    ranges: dict[str, Range] = Field(min_length=1, max_length=64)
    """By key, { from = …, to = … }."""


class NamedPlanner(Table):
    """A planner with settings and a label of its own."""

    name: str = Field(min_length=1)
    """A planner's name, or file.py:Class."""
    label: str = Field(default="", max_length=100)
    """What tables call it; its name when left out."""
    settings: dict[str, Value] = {}
    """Keys of [planner] and values."""


class Case(Table):
    """Scenarios, planners and seeds that are combined with each other."""

    scenarios: list[str] | None = Field(default=None, min_length=1)
    """Built-in names, or paths from the study's folder; required."""
    planners: list[str | NamedPlanner] | None = Field(default=None, min_length=1)
    """Names or { name, label, settings }; else the scenario's own."""
    seeds: (
        Annotated[int, Field(gt=0, le=1_000_000)]
        | Annotated[list[Annotated[int, Field(ge=0, le=LARGEST_SEED)]], Field(min_length=1)]
        | None
    ) = Field(default=None, description="How many, from 1 on, up to 1000000, or a list; else 1.")
    improve: bool | None = None
    """true or false: whether motions are made exact and shorter; else false."""
    check: bool | None = None
    """true or false: whether solved runs are checked from files; else false."""
    settings: dict[str, Value] | None = None
    """Values by a scenario's dotted keys."""
    sweep: dict[str, Annotated[list[Value], Field(min_length=1)]] | None = Field(
        default=None, max_length=64
    )
    """Lists of values by dotted key; all combinations are run."""
    sobol: Sobol | None = None
    """Ranges by dotted key, and points."""


class Study(Case):
    """A study: what all cases share, and the cases, if there are several."""

    schema_version: Literal[1] = Field(alias="schema")
    """The number 1, of this format; required."""
    title: str = Field(min_length=1)
    """What the study asks, in a line; required."""
    limits: Limits = Limits()
    """Of each run."""
    case: list[Case] = []
    """[[case]]: further combinations, with keys of their own."""
    _path: Path = PrivateAttr(default=Path("study.toml"))

    @property
    def path(self) -> Path:
        """Of its file."""
        return self._path

    @property
    def cases(self) -> list[Case]:
        """The cases, with what the study says for all of them where they are silent."""
        shared = {key: getattr(self, key) for key in Case.model_fields}
        return [
            Case.model_construct(**{**shared, **{k: getattr(one, k) for k in one.model_fields_set}})
            for one in (self.case or [Case()])
        ]


def read_study(path: Path) -> Study:
    """Read the file of a study.

    Raises:
        InputError: With every mistake that can be found without its scenarios.
    """
    document = toml_document(read_text(path), path.name, "Write [sobol] or several studies.")
    if "system" in document:
        what = "this is a scenario, not a study."
        raise InputError([Mistake(path.name, what, f"`plan {path}` plans it.")])
    mistakes = []
    try:
        study = Study.model_validate(document)
        study._path = path
    except ValidationError as error:
        mistakes += [_mistake(line, path) for line in _told(error)]
    mistakes += _misplaced(document, path)
    told = list(dict.fromkeys(mistakes))
    if len(told) > 100:  # more are not read
        rest = Mistake(path.name, "there are more mistakes than these.", "Mend these first.")
        told = [*told[:100], rest]
    if told:
        raise InputError(told)
    return study


def _misplaced(document: Mapping[str, Any], path: Path) -> Iterator[Mistake]:
    """Yield what cannot be left out, and keys that stand where others belong.

    The document need not be one of a study in other respects: all mistakes are told at once.
    """
    named = document.get("case")
    cases = [case for case in named if isinstance(case, dict)] if isinstance(named, list) else []
    for number, case in enumerate(cases or [{}], start=1):
        where = f"{path.name} [[case]] {number}" if cases else path.name
        told = {**document, **case}
        if "scenarios" not in told:
            yield Mistake(where, "no scenarios are named.", 'Write scenarios = ["…"].')
        swept = [*_keys(told.get("sweep")), *_keys(_table(told.get("sobol")).get("ranges"))]
        for key in [*_keys(told.get("settings")), *swept, *_planner_keys(told.get("planners"))]:
            # without the quotes and spaces that TOML allows around parts of a key
            plain = ".".join(part.strip(" \t\"'") for part in key.split("."))
            if remedy := NAMED_ELSEWHERE.get(plain):
                yield Mistake(f"{where} {key_text(key)}", "this is not set here.", remedy)
        for key, count in sorted(Counter(swept).items()):
            if count > 1:
                yield Mistake(f"{where} {key_text(key)}", "it is swept twice.", "Leave one out.")
        set_too = {*_keys(told.get("settings")), *_planner_keys(told.get("planners"))}
        for key in sorted({*swept} & set_too):
            what = "it is swept, and set to one value."
            yield Mistake(f"{where} {key_text(key)}", what, "Leave one out, or write two [[case]].")
        seeds = told.get("seeds")
        if isinstance(seeds, list) and len(set(map(repr, seeds))) < len(seeds):
            what = "a seed is listed twice, which would count a run twice."
            yield Mistake(f"{where} seeds", what, "Leave it out.")


def _table(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _keys(value: object) -> list[str]:
    return list(_table(value))


def _planner_keys(planners: object) -> list[str]:
    """Return the keys that planners of a list set, as a scenario has them."""
    tables = [_table(one) for one in planners] if isinstance(planners, list) else []
    return [f"planner.{key}" for one in tables for key in _keys(one.get("settings"))]


def _told(error: ValidationError) -> list[ErrorDetails]:
    """Return what pydantic found; of a value that may be of several kinds only what is nearest.

    Where a list or table has a mistake inside, that it is no number or text is not one more.
    """
    lines = error.errors(include_url=False)
    places = [tuple(_place(line["loc"])[0]) for line in lines]
    outer = {place[:length] for place in places for length in range(len(place))}
    return [line for line, place in zip(lines, places, strict=True) if place not in outer]


def _mistake(line: ErrorDetails, path: Path) -> Mistake:
    """Return what pydantic found, with its place in the file and what would work there."""
    keys, model, about = _place(line["loc"])
    where = f"{path.name} {_written(keys)}".rstrip()
    if line["type"] == "extra_forbidden":
        known = sorted(fields_of(model))
        unknown = unknown_name("key", str(keys[-1]), known=known)
        return Mistake(where, unknown.what, unknown.remedy)
    if line["type"] == "missing":
        return Mistake(where, "it is missing.", about)
    if line["type"] == "value_error":
        return Mistake(where, f"{line['ctx']['error']}.", about)
    return Mistake(where, f"{shown(line['input'])} does not fit here.", about)


def _place(location: tuple[int | str, ...]) -> tuple[list[int | str], type[Table], str]:
    """Return the keys of a location, without pydantic's branches, the table, and the meaning."""
    keys: list[int | str] = []
    model: type[Table] = Study
    about = ""
    for part in location:
        fields = fields_of(model)
        if isinstance(part, int):
            keys.append(part)
        elif part in fields:
            keys.append(part)
            about = fields[part].description or about
            model = model_in(fields[part].annotation, Table) or model
        elif not part.startswith(("function-", "constrained-", "list[", "dict[")) and part not in (
            *("int", "float", "str", "bool", "NamedPlanner"),
        ):
            keys.append(part)
    return keys, model, about


def _written(keys: list[int | str]) -> str:
    """Return keys as they stand in a file; entries of lists count from 1."""
    if keys[:1] == ["case"] and len(keys) > 1:
        return f"[[case]] {int(keys[1]) + 1} {_written(keys[2:])}".rstrip()
    return ".".join(key_text(k) if isinstance(k, str) else f"{k + 1}" for k in keys)
