"""What a page tells of a plan: of a report, which anybody may have written, what fits."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

TEXTS = ("status", "message", "planner")
NUMBERS = ("seed", "iterations", "cost", "duration", "goal_distance")
LARGEST = sys.float_info.max  # JSON has larger ones


def facts_told(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of a report that a page tells, each of the kind that its scripts expect.

    Numbers that are not finite are None, as JSON requires; what is of another kind is left out.
    """
    kept = {key: report[key] for key in TEXTS if isinstance(report.get(key), str)}
    kept |= {key: _number(report[key]) for key in NUMBERS if key in report}
    parts, margin, checks = (
        report.get(key) for key in ("goal_distance_by_unit", "margin", "verification")
    )
    if isinstance(parts, Mapping):
        kept["goal_distance_by_unit"] = {str(unit): _number(part) for unit, part in parts.items()}
    if isinstance(margin, Mapping):
        kept["margin"] = _margin(margin)
    found = [check for check in _listed(checks) if isinstance(check, Mapping)]
    said = [*_listed(report.get("notes")), *_listed(report.get("warnings"))]
    told = [sentence for sentence in said if isinstance(sentence, str)]
    return kept | {"verification": [_check(check) for check in found], "warnings": told}


def _margin(margin: Mapping[str, Any]) -> dict[str, Any]:
    numbers = {key: _number(margin.get(key)) for key in ("clearance", "required", "time")}
    return {**numbers, "beside": [str(name) for name in _listed(margin.get("beside"))]}


def _check(check: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": str(check.get("name", "")),
        "value": _number(check.get("value")),
        "limit": _number(check.get("limit")),
        "passed": check.get("passed") is True,
        "detail": str(check.get("detail") or ""),
    }


def _number(value: object) -> int | float | None:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST:
        return value
    return None


def _listed(value: object) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()
