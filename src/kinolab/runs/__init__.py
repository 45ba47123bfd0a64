"""The folder of a run: everything needed to check, draw and mail a plan."""

from kinolab.runs.dynobench_result import has_its_steps, result_text
from kinolab.runs.folder import (
    MODEL,
    PAGE,
    PLOT_NAMES,
    Run,
    add_diagnosis,
    check_run,
    read_run,
    replaced_scenario,
    require_place,
    still_there,
    write_run,
    written_at,
)
from kinolab.runs.report import check_to_json, facts_of_plan, margin_to_json

__all__ = [
    "MODEL",
    "PAGE",
    "PLOT_NAMES",
    "Run",
    "add_diagnosis",
    "check_run",
    "check_to_json",
    "facts_of_plan",
    "has_its_steps",
    "margin_to_json",
    "read_run",
    "replaced_scenario",
    "require_place",
    "result_text",
    "still_there",
    "write_run",
    "written_at",
]
