"""The folder of a run: everything needed to check, draw and mail a plan."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.runs.dynobench_result import has_its_steps as has_its_steps
    from kinolab.runs.dynobench_result import result_text as result_text
    from kinolab.runs.folder import FILM as FILM
    from kinolab.runs.folder import MODEL as MODEL
    from kinolab.runs.folder import PAGE as PAGE
    from kinolab.runs.folder import PLOT_NAMES as PLOT_NAMES
    from kinolab.runs.folder import Run as Run
    from kinolab.runs.folder import add_to_report as add_to_report
    from kinolab.runs.folder import check_run as check_run
    from kinolab.runs.folder import read_run as read_run
    from kinolab.runs.folder import replaced_scenario as replaced_scenario
    from kinolab.runs.folder import require_place as require_place
    from kinolab.runs.folder import still_there as still_there
    from kinolab.runs.folder import write_run as write_run
    from kinolab.runs.folder import written_at as written_at
    from kinolab.runs.report import check_to_json as check_to_json
    from kinolab.runs.report import facts_of_plan as facts_of_plan
    from kinolab.runs.report import margin_to_json as margin_to_json
    from kinolab.runs.report import warnings_before as warnings_before

__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)
