"""What a scenario file says: its schema, how it is read, checked and written."""

from kinolab.scenario.file_lookup import builtin_scenarios, read_text, scenario_path
from kinolab.scenario.issues import Issue, Origin, Override
from kinolab.scenario.load import (
    check_changed,
    load_scenario,
    read_scenario,
    scenario_from,
    sound,
)
from kinolab.scenario.locations import mistake_at, place_at
from kinolab.scenario.names import check_angles, check_names
from kinolab.scenario.overrides import apply_changes, apply_overrides, override_place
from kinolab.scenario.planner_keys import argument_mistakes, shared_settings
from kinolab.scenario.rules import PLANNER_KEYS
from kinolab.scenario.schema import (
    DirectionGoal,
    GoalSection,
    IntegrationSection,
    KeepOut,
    ObstacleEntry,
    PlannerSection,
    PointGoal,
    RenderSection,
    Scenario,
    SystemSection,
    WorldSection,
    axis_vector,
)
from kinolab.scenario.values import Effort, improvement_seconds
from kinolab.scenario.write import write_scenario

__all__ = [
    "PLANNER_KEYS",
    "DirectionGoal",
    "Effort",
    "GoalSection",
    "IntegrationSection",
    "Issue",
    "KeepOut",
    "ObstacleEntry",
    "Origin",
    "Override",
    "PlannerSection",
    "PointGoal",
    "RenderSection",
    "Scenario",
    "SystemSection",
    "WorldSection",
    "apply_changes",
    "apply_overrides",
    "argument_mistakes",
    "axis_vector",
    "builtin_scenarios",
    "check_angles",
    "check_changed",
    "check_names",
    "improvement_seconds",
    "load_scenario",
    "mistake_at",
    "override_place",
    "place_at",
    "read_scenario",
    "read_text",
    "scenario_from",
    "scenario_path",
    "shared_settings",
    "sound",
    "write_scenario",
]
