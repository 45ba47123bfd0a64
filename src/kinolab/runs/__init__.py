"""The folder of a run: everything needed to check, draw and mail a plan."""

from kinolab.runs.dynobench_result import has_its_steps, result_text
from kinolab.runs.folder import (
    MODEL,
    PAGE,
    Run,
    add_diagnosis,
    check_run,
    check_to_json,
    read_run,
    writable,
    write_run,
)

__all__ = [
    "MODEL",
    "PAGE",
    "Run",
    "add_diagnosis",
    "check_run",
    "check_to_json",
    "has_its_steps",
    "read_run",
    "result_text",
    "writable",
    "write_run",
]
