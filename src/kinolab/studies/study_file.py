"""The file of a study: what is run, how often, with which settings and within which limits."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.scenario.file_lookup import read_text
from kinolab.scenario.toml_text import key_text, shown

MOST_SEEDS = 1_000_000
MOST_POINTS = 65_536  # of a Sobol sequence
NAMED_ELSEWHERE = {  # keys of a scenario that a study names by keys of its own
    "planner.name": "List planners under planners.",
    "planner.seed": "Give seeds.",
    "planner.time_limit": "Give [limits] search.",
    "planner.max_iterations": "Give [limits] iterations.",
    "system.name": "List scenarios under scenarios.",
    "system.file": "List scenarios under scenarios.",
}

Positive = Annotated[float, Field(gt=0.0)]
Value = bool | int | float | str | list[Any] | dict[str, Any]


class Table(BaseModel):
    """What all tables share: strict types, finite numbers, no unknown keys, no changes."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


class Limits(Table):
    """``[limits]``: of each run; what is left out is not limited, or as the scenario says."""

    search: Annotated[
        Positive | None, Field(description="Processor time of a search, in s; the scenario's.")
    ] = None
    iterations: Annotated[
        Annotated[int, Field(gt=0)] | None,
        Field(description="Iterations of a search; the scenario's."),
    ] = None
    cpu: Annotated[
        Positive | None, Field(description="Processor time of a run, in s; a run ends there.")
    ] = None
    memory: Annotated[
        Positive | None, Field(description="Memory of a run, in MB; a run ends there.")
    ] = None


class Range(Table):
    """Between which values a Sobol sequence varies a key."""

    model_config = ConfigDict(populate_by_name=True)

    low: Annotated[float, Field(alias="from", description="Lowest value.")]
    high: Annotated[float, Field(alias="to", description="Highest value.")]
    scale: Annotated[
        Literal["linear", "log"], Field(description="How values are spread between them.")
    ] = "linear"

    @model_validator(mode="after")
    def _sensible(self) -> Range:
        if self.low >= self.high:
            raise ValueError("its from is not below its to")
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError("a logarithmic scale needs values above 0")
        return self


class Sobol(Table):
    """``[sobol]``: points of a Sobol sequence in the ranges of several keys."""

    points: Annotated[
        int, Field(gt=0, le=MOST_POINTS, description="How many; a power of 2 is best.")
    ]
    seed: Annotated[int, Field(ge=0, description="Of the scrambling.")] = 1
    ranges: Annotated[
        dict[str, Range], Field(min_length=1, description="By key, { from = …, to = … }.")
    ]


class NamedPlanner(Table):
    """A planner with settings and a label of its own."""

    name: Annotated[str, Field(min_length=1, description="A planner's name, or file.py:Class.")]
    label: Annotated[str, Field(description="What tables call it; its name when left out.")] = ""
    settings: Annotated[dict[str, Value], Field(description="Keys of [planner] and values.")] = {}


class Case(Table):
    """Scenarios, planners and seeds that are combined with each other."""

    scenarios: Annotated[
        list[str] | None,
        Field(min_length=1, description="Built-in names, or paths from the study's folder."),
    ] = None
    planners: Annotated[
        list[str | NamedPlanner] | None,
        Field(min_length=1, description="Names or { name, label, settings }; the scenario's own."),
    ] = None
    seeds: Annotated[
        Annotated[int, Field(gt=0, le=MOST_SEEDS)]
        | Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1)]
        | None,
        Field(description="How many, from 1 on, or a list."),
    ] = None
    improve: Annotated[
        bool | None, Field(description="Whether motions are made exact and shorter; false.")
    ] = None
    check: Annotated[
        bool | None, Field(description="Whether each run is re-checked from its files; false.")
    ] = None
    settings: Annotated[
        dict[str, Value] | None, Field(description="Values by a scenario's dotted keys.")
    ] = None
    sweep: Annotated[
        dict[str, Annotated[list[Value], Field(min_length=1)]] | None,
        Field(description="Lists of values by dotted key; all combinations are run."),
    ] = None
    sobol: Annotated[Sobol | None, Field(description="Ranges by dotted key, and points.")] = None


class Study(Case):
    """A study: what all cases share, and the cases, if there are several.

    Attributes:
        path: Of its file.
    """

    model_config = ConfigDict(populate_by_name=True)

    schema_version: Annotated[Literal[1], Field(alias="schema", description="1.")]
    title: Annotated[str, Field(min_length=1, description="What the study asks, in a line.")]
    limits: Annotated[Limits, Field(description="Of each run.")] = Limits()
    case: Annotated[
        list[Case], Field(description="[[case]]: further combinations, with keys of their own.")
    ] = []
    path: Path = Field(default=Path("study.toml"), exclude=True)

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
    text = read_text(path)
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError([Mistake(path.name, f"this is not TOML: {error}.")]) from None
    if document.keys() >= {"system"}:
        what = "this is a scenario, not a study."
        raise InputError([Mistake(path.name, what, f"`plan {path}` plans it.")])
    document.pop("path", None)
    try:
        study = Study.model_validate(document).model_copy(update={"path": path})
    except ValidationError as error:
        lines = error.errors(include_url=False)
        raise InputError(dict.fromkeys(_mistake(line, path) for line in lines)) from None
    mistakes = list(_missing(study))
    if mistakes:
        raise InputError(mistakes)
    return study


def _missing(study: Study) -> Iterator[Mistake]:
    """Yield what cannot be left out, and keys that stand where others belong."""
    for number, case in enumerate(study.cases, start=1):
        where = f"{study.path.name} [[case]] {number}" if study.case else study.path.name
        if not case.scenarios:
            yield Mistake(where, "no scenarios are named.", 'Write scenarios = ["…"].')
        swept = [*(case.sweep or {}), *(case.sobol.ranges if case.sobol else {})]
        for key in [*(case.settings or {}), *swept]:
            if key in NAMED_ELSEWHERE:
                yield Mistake(
                    f"{where} {key_text(key)}", "this is not set here.", NAMED_ELSEWHERE[key]
                )
        for key in sorted({key for key in swept if swept.count(key) > 1}):
            yield Mistake(f"{where} {key_text(key)}", "it is swept twice.", "Leave one out.")


def _mistake(line: ErrorDetails, path: Path) -> Mistake:
    """Return what pydantic found, with its place in the file and what would work there."""
    keys, model, about = _place(line["loc"])
    where = f"{path.name} {_written(keys)}".rstrip()
    if line["type"] == "extra_forbidden":
        known = sorted(field.alias or name for name, field in model.model_fields.items())
        known = [name for name in known if name != "path"]
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
        fields = {field.alias or name: field for name, field in model.model_fields.items()}
        if isinstance(part, int):
            keys.append(part)
        elif part in fields and part != "path":
            keys.append(part)
            about = fields[part].description or about
            model = _model_in(fields[part].annotation) or model
        elif not part.startswith(("function-", "constrained-", "list[", "dict[")) and part not in (
            *("int", "float", "str", "bool", "NamedPlanner"),
        ):
            keys.append(part)
    return keys, model, about


def _model_in(annotation: Any) -> type[Table] | None:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    return next(filter(None, map(_model_in, get_args(annotation))), None)


def _written(keys: list[int | str]) -> str:
    """Return keys as they stand in a file; entries of lists count from 1."""
    if keys[:1] == ["case"] and len(keys) > 1:
        return f"[[case]] {int(keys[1]) + 1} {_written(keys[2:])}".rstrip()
    return ".".join(key_text(k) if isinstance(k, str) else f"{k + 1}" for k in keys)
