"""From a study to its runs: every combination of scenario, planner, settings and seed."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.loading import load
from kinolab.problem import PlanningTask
from kinolab.scenario import builtin_scenarios
from kinolab.scenario.toml_text import value_text
from kinolab.search.plugins import seen_from
from kinolab.studies.problem_files import SCENARIO, ProblemFiles, files_of
from kinolab.studies.study_file import Case, NamedPlanner, Range, Sobol, Study


@dataclass(frozen=True)
class RunSpec:
    """One run of a study.

    Attributes:
        index: Its place in the study, from 0.
        scenario: Name of the scenario.
        planner: What tables call the planner.
        settings: What was swept, by dotted key.
        seed: Of the random numbers.
        files: Key of the files that it is run from.
        improve: Whether the motion is made exact and shorter.
        check: Whether it is re-checked from its files.
        fixed: What the study sets for it besides, by dotted key.
    """

    index: int
    scenario: str
    planner: str
    settings: tuple[tuple[str, Any], ...]
    seed: int
    files: str
    improve: bool
    check: bool
    fixed: tuple[tuple[str, Any], ...] = ()

    @property
    def overrides(self) -> tuple[str, ...]:
        """What was swept, as ``--set`` takes it."""
        return tuple(assignment(key, value) for key, value in self.settings)

    def identity(self, limits: Mapping[str, Any]) -> str:
        """Return a hash of all that decides its result."""
        told = [self.files, self.overrides, self.seed, self.improve, self.check, dict(limits)]
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:20]


@dataclass(frozen=True)
class StudyRuns:
    """All runs of a study, and the files that they are run from.

    Attributes:
        runs: In their order.
        files: By key.
    """

    runs: tuple[RunSpec, ...]
    files: Mapping[str, ProblemFiles]


def assignment(key: str, value: Any) -> str:
    """Return a value for a key as ``--set`` takes it."""
    return f"{key}={value_text(value)}"


def expanded(study: Study, root: Path) -> StudyRuns:
    """Return the runs of a study, whose scenarios, planners and settings have been tried.

    Seeds vary slowest, so that half a study is one too.

    Args:
        root: Folder into which the files of its scenarios are written.

    Raises:
        InputError: With every mistake in scenarios, planners and settings.
    """
    if (count := run_count(study)) > 1_000_000:
        what = f"it has {count} runs."
        raise InputError([Mistake(study.path.name, what, "At most 1000000 are made.")])
    mistakes: list[Mistake] = []
    packed: dict[str, ProblemFiles] = {}
    meanings: dict[tuple[object, ...], tuple[object, ...]] = {}
    groups: list[tuple[int, tuple[Any, ...]]] = []
    for number, case in enumerate(study.cases, start=1):
        where = f"{study.path.name} [[case]] {number}" if study.case else study.path.name
        seeds = _seeds(case)
        points = _points(case)
        chosen: Sequence[str | NamedPlanner | None] = case.planners or [None]
        for source, planner in itertools.product(case.scenarios or [], chosen):
            one = NamedPlanner(name=planner) if isinstance(planner, str) else planner
            try:
                problem, fixed = _loaded(study, case, source, one)
                files = files_of(problem)
                _try_ends(files.written(root), points)
            except InputError as error:
                named = f"{where} {source}" + (f", {one.label or one.name}" if one else "")
                mistakes += [
                    Mistake(f"{named}: {m.where.removeprefix('--set ')}", m.what, m.remedy)
                    for m in error.mistakes
                ]
                continue
            packed[files.key] = files
            label = (one.label or one.name) if one else problem.scenario.planner.name
            told = (problem.name, label, files.key, bool(case.improve), bool(case.check), fixed)
            name = (problem.name, label, frozenset(key for key, _ in points[0]))
            if meanings.setdefault(name, told[2:4]) != told[2:4]:
                what = f"{label!r} on {problem.name!r} already names something else."
                remedy = 'Give one a label: planners = [{ name = "…", label = "…" }].'
                mistakes.append(Mistake(where, what, remedy))
                continue
            groups += [(seed, (*told, point)) for seed in seeds for point in points]
    if mistakes:
        raise InputError(dict.fromkeys(mistakes))
    groups.sort(key=lambda group: group[0])  # stable: otherwise as they stand in the file
    runs = [
        RunSpec(index, scenario, label, point, seed, key, improve, check, fixed)
        for index, (seed, (scenario, label, key, improve, check, fixed, point)) in enumerate(groups)
    ]
    return StudyRuns(tuple(runs), packed)


def run_count(study: Study) -> int:
    """Return how many runs a study has, without making any of them."""
    return sum(
        len(case.scenarios or [])
        * len(case.planners or [None])
        * math.prod(len(values) for values in (case.sweep or {}).values())
        * (case.sobol.points if case.sobol else 1)
        * len(_seeds(case))
        for case in study.cases
    )


def _seeds(case: Case) -> Sequence[int]:
    return case.seeds if isinstance(case.seeds, list) else range(1, (case.seeds or 1) + 1)


def _points(case: Case) -> list[tuple[tuple[str, Any], ...]]:
    """Return all settings of a case: the grid of its sweep times the points of its sequence."""
    sweep = case.sweep or {}
    grid = [tuple(zip(sweep, values, strict=True)) for values in itertools.product(*sweep.values())]
    sequence = list(sobol_points(case.sobol)) if case.sobol else [()]
    return [(*point, *further) for point, further in itertools.product(grid, sequence)]


def sobol_points(sobol: Sobol) -> Iterator[tuple[tuple[str, float | int], ...]]:
    """Yield the points of a scrambled Sobol sequence in its ranges.

    Source: Sobol, USSR Comput. Math. Math. Phys. 7 (1967); scrambling after Owen, as in SciPy.
    """
    from scipy.stats import qmc

    sampler = qmc.Sobol(len(sobol.ranges), rng=np.random.default_rng(sobol.seed))
    whole = sampler.random_base2(max(0, (sobol.points - 1).bit_length()))
    for row in whole[: sobol.points]:
        placed = zip(sobol.ranges.items(), row.tolist(), strict=True)
        yield tuple((key, _in_range(limits, share)) for (key, limits), share in placed)


def _in_range(limits: Range, share: float) -> float | int:
    if limits.scale == "log":
        low, high = math.log(limits.low), math.log(limits.high)
        value = math.exp(low + (high - low) * share)
    else:
        value = limits.low + (limits.high - limits.low) * share
    value = min(max(value, limits.low), limits.high)  # rounding leads no further
    return round(value) if limits.whole else value


def _loaded(
    study: Study, case: Case, source: str, planner: NamedPlanner | None
) -> tuple[PlanningTask, tuple[tuple[str, Any], ...]]:
    """Return the problem of a scenario under a planner and what the study sets, and these."""
    folder = study.path.parent
    path = source if source in builtin_scenarios() else str(folder / source)
    fixed = dict(case.settings or {})
    overrides = []
    if planner is not None:
        where = builtin_scenarios().get(source, Path(path)).resolve().parent
        name = planner.name
        if ".py:" in name:
            name = seen_from(where, str((folder / name).resolve()))
        overrides = [assignment("planner.name", name)]
        fixed |= {f"planner.{key}": value for key, value in planner.settings.items()}
    overrides += [assignment(key, value) for key, value in fixed.items()]
    return load(path, overrides=overrides), tuple(fixed.items())


def _try_ends(folder: Path, points: Sequence[tuple[tuple[str, Any], ...]]) -> None:
    """Load a problem once with each value of a grid, and with the ends of ranges.

    Raises:
        InputError: If a key does not exist, or a value does not fit.
    """
    tried: set[str] = set()
    for point in _outermost(points):
        overrides = [assignment(key, value) for key, value in point]
        if tried.issuperset(overrides):
            continue
        tried.update(overrides)
        load(folder / SCENARIO, overrides=overrides)


def _outermost(
    points: Sequence[tuple[tuple[str, Any], ...]],
) -> Iterator[tuple[tuple[str, Any], ...]]:
    """Yield the points whose values are the lowest or highest of a key, or not numbers."""
    for place in range(len(points[0])):
        values = [point[place][1] for point in points]
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
        if numbers:
            yield points[int(np.argmin(values))]
            yield points[int(np.argmax(values))]
        else:
            seen: set[str] = set()
            for point, value in zip(points, values, strict=True):
                if (text := value_text(value)) not in seen:
                    seen.add(text)
                    yield point
