"""Executions as plain data, and in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Execution, ExecutionRun
from kinolab.analyze.execute.execution_diagnosis import ExecutionDiagnosis, shortages
from kinolab.dynamics.model.units import state_units
from kinolab.problem import PlanningTask
from kinolab.verification.tube.uncertainty import kept_by_default


def execution_to_json(
    problem: PlanningTask, execution: Execution, diagnosis: ExecutionDiagnosis | None = None
) -> dict[str, Any]:
    """Return an execution as plain data; what is not finite becomes null."""
    conditions = execution.conditions
    return {
        "conditions": dict(vars(conditions)),
        "varied": conditions.shares(conditions.varied(problem.system)),
        "seed": execution.seed,
        "runs": execution.total,
        "reached": execution.reached,
        "counts": execution.counts,
        "failures": [
            {
                "count": group.count,
                "outcome": group.first.outcome,
                "cause": group.first.cause,
                "at_start": group.first.at_start,
                "run": group.run + 1,
            }
            for group in execution.failures
        ],
        "diagnosis": [] if diagnosis is None else list(diagnosis.sentences),
        "each": [_run_to_json(run) for run in execution.runs],
    }


def _run_to_json(run: ExecutionRun) -> dict[str, Any]:
    failure = None
    if run.failure is not None:
        failure = asdict(run.failure)
        del failure["outcome"]
    return {
        "outcome": run.outcome,
        "failure": failure,
        "excess": run.excess if np.isfinite(run.excess) else None,
        "deviation": run.deviation if np.isfinite(run.deviation) else None,
        "steps": run.steps,
        "parameters": run.parameters,
    }


def summary_lines(
    problem: PlanningTask, execution: Execution, diagnosis: ExecutionDiagnosis | None = None
) -> Iterator[str]:
    """Yield what the terminal says of an execution: how many, why not, what to change."""
    yield f"{execution.reached} of {execution.total} runs reached the goal"
    yield f"  {varied_text(problem, execution.conditions)}"
    groups = execution.failures
    yield from (f"  {group}" for group in groups[:6])
    if rest := sum(group.count for group in groups[6:]):
        yield f"  {rest} failed otherwise: see `why` in execution.csv"
    far, run = execution.farthest
    if far.amount > 0:
        units = dict(zip(problem.model.state_names, state_units(problem.model), strict=True))
        amount = f"{far.amount:.3g} {units[far.name]}".rstrip()
        when = f"at {far.time:.3g} s in run {run + 1}"
        yield f"  farthest from the plan: {far.name} was off by {amount} {when}"
    if diagnosis is not None:
        yield from (f"  {sentence}" for sentence in diagnosis.sentences)
    elif groups:  # what the runs themselves tell
        yield from (f"  {sentence}" for sentence in shortages(execution, groups[0]))


def varied_text(problem: PlanningTask, conditions: Conditions) -> str:
    """Say what differed from run to run, and what did not."""
    system = conditions.varied(problem.system)
    parts = [
        f"{', '.join(names)} by up to {share:.3g} %"
        for share, names in _by_share(conditions.shares(system)).items()
    ]
    if conditions.noise:
        parts.append(f"measurements by {100 * conditions.noise:.3g} % of each state's scale")
    if conditions.disturbance:
        parts.append(f"inputs by {100 * conditions.disturbance:.3g} % of their range")
    text = f"varied: {'; '.join(parts) or 'nothing'}"
    kept = [*kept_by_default(system), *conditions.keep]
    if conditions.parameters and (kept := [n for n in kept if n not in conditions.vary]):
        text += f" (kept: {', '.join(dict.fromkeys(kept))})"
    if conditions.built:
        values = ", ".join(f"{name} = {value:g}" for name, value in conditions.built.items())
        text += f"; built with {values}"
    return text


def _by_share(shares: Mapping[str, float]) -> dict[float, list[str]]:
    """Return the names of parameters by how much they vary, in percent."""
    names: dict[float, list[str]] = {}
    for name, share in shares.items():
        names.setdefault(100 * share, []).append(name)
    return names
