"""Choose: the machine with its parameters, the planner with its settings, limits and the cost."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from kinolab import planners, systems
from kinolab.problem import PlanningTask
from kinolab.scenario import shared_settings
from kinolab.settings import Setting, settings_of
from kinolab.studio.core import edits
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.core.scenario_text import Drop, Put
from kinolab.studio.scene.page_inputs import on_hand, show
from kinolab.studio.scene.session import Session

OWN = "(of its own file)"
LIMITED = "Of this scenario, within those of the machine; equal ones are the machine's own."
UNBOUNDED = "The workspace's limits; equal ones are none."


class ChoosePanel:
    """The tab in which machine, planner, limits and cost are chosen."""

    def __init__(self, session: Session) -> None:
        self._session, gui = session, session.server.gui
        self._made: Any = None
        self._parts: list[Any] = []
        with gui.add_folder("Machine"):
            self._machine = on_hand(
                session, gui.add_dropdown("Machine", (OWN, *systems.names())), self._take_machine
            )
            self._about = gui.add_markdown("")
            self._parameters = gui.add_folder("Parameters", expand_by_default=False)
        with gui.add_folder("World"):
            self._clearance = on_hand(
                session,
                gui.add_number("Clearance [m]", 0.0, min=0.0, step=0.01,
                               hint="What plans keep from every obstacle."),
                lambda v: self._put("clearance", ("world", "clearance"), float(v)),
            )  # fmt: skip
            self._ground = on_hand(
                session,
                gui.add_checkbox("Ground", True),
                lambda on: self._put("ground", ("world", "ground"), "plane" if on else "none"),
            )
            self._bounds = {
                axis: on_hand(
                    session,
                    gui.add_vector2(f"{axis} from, to [m]", (0.0, 0.0), step=0.1, hint=UNBOUNDED),
                    partial(self._bound, axis),
                )
                for axis in "xyz"
            }
        self._limits = gui.add_folder("Limits", expand_by_default=False)
        self._ends: dict[str, Any] = {}  # inputs of the limits, by the names of what they limit
        with gui.add_folder("Planner"):
            self._planner = on_hand(
                session, gui.add_dropdown("Planner", planners.names()), self._take_planner
            )
            self._explained = gui.add_markdown("")
            self._settings = gui.add_folder("Settings", expand_by_default=False)
        with gui.add_folder("Cost", expand_by_default=False):
            gui.add_markdown("Weights of what a motion costs; all 0: its duration.")
            self._costs = {
                kind: on_hand(
                    session, gui.add_number(kind, 0.0, min=0.0, step=0.1), lambda _: self._weigh()
                )
                for kind in ("time", "effort", "energy")
            }
        session.listen(self._listen)

    def _listen(self, meaning: ScenarioMeaning) -> None:
        problem = meaning.problem
        if problem is None or meaning.stale:
            return
        scenario = problem.scenario
        show(self._machine, scenario.system.name or OWN)
        show(self._planner, _known(scenario.planner.name))
        show(self._clearance, float(scenario.world.clearance))
        show(self._ground, scenario.world.ground == "plane")
        for axis, handle in self._bounds.items():
            show(handle, tuple(map(float, scenario.world.bounds.get(axis, (0.0, 0.0)))))
        objective = scenario.objective
        for kind, handle in self._costs.items():
            show(handle, float(getattr(objective, kind)) if objective else 0.0)
        for name, handle in self._ends.items():
            show(handle, _limits(problem).get(name, handle.value))
        made = (problem.machine.name, scenario.system.parameters, scenario.planner)
        if made != self._made:
            self._made = made
            self._build(problem)

    def _build(self, problem: PlanningTask) -> None:
        """Make the inputs of parameters and settings anew."""
        for part in self._parts:
            part.remove()
        self._parts = []
        name = problem.scenario.system.name
        self._about.content = systems.summary(name) if name else ""
        with self._parameters:
            for parameter in _parameters(problem):
                self._parameter(*parameter)
        self._ends = {}
        with self._limits:
            for what, ends in _limits(problem).items():
                self._limit(what, ends)
        section = problem.scenario.planner
        planner = planners.get(section.name) if section.name in planners.names() else None
        self._explained.content = (
            (planner.__doc__ or "").strip().partition("\n")[0] if planner else ""
        )
        with self._settings:
            for setting in shared_settings():
                self._setting(setting, getattr(section, setting.name))
            for setting in settings_of(planner) if planner else ():
                self._setting(setting, section.settings.get(setting.name, setting.default))

    def _parameter(self, name: str, value: float, unit: str) -> None:
        gui, session = self._session.server.gui, self._session
        label = f"{name} [{unit}]" if unit else name
        path = ("system", "parameters", name)

        def work(v: Any) -> None:
            self._put(f"parameter {name}", path, float(v))

        handle: Any
        if value > 0.0:
            # A parameter's slider goes from a quarter of its value to four times
            low, high = value / 4.0, value * 4.0
            step = float(f"{(high - low) / 200:.1g}")  # of a slider
            handle = gui.add_slider(label, min(low, value), high, step, value)
        else:
            handle = gui.add_number(label, value)
        self._parts.append(on_hand(session, handle, work))

    def _limit(self, name: str, ends: tuple[float, float]) -> None:
        handle = self._session.server.gui.add_vector2(name, ends, step=0.05, hint=LIMITED)
        path = ("bounds", name)
        self._ends[name] = on_hand(self._session, handle, partial(self._between, name, path))
        self._parts.append(handle)

    def _setting(self, setting: Setting, value: Any) -> None:
        """Make the input of a planner's setting, if a page has one for its kind."""
        gui, path = self._session.server.gui, ("planner", setting.name)
        label = f"{setting.name} [{setting.unit}]" if setting.unit else setting.name
        hint = f"{setting.meaning} {setting.range}".strip()
        handle: Any
        if isinstance(value, bool):
            handle = gui.add_checkbox(label, value, hint=hint)
        elif isinstance(value, int | float):
            handle = gui.add_number(label, value, hint=hint)
        elif value is None or isinstance(value, str):
            shown = "" if value is None else value
            handle = gui.add_text(label, shown, hint=f"{hint} (text or a number; empty: left out)")
        else:
            return
        self._parts.append(on_hand(self._session, handle, lambda v: self._set(path, v)))

    def _set(self, path: tuple[str, ...], value: Any) -> None:
        if value == "":
            self._session.edit(f"leave out {path[-1]}", [Drop(path)])
            return
        if isinstance(value, str):
            for kind in (int, float):
                try:
                    value = kind(value)
                    break
                except ValueError:
                    pass
        self._put(path[-1], path, value)

    def _put(self, what: str, path: tuple[str, ...], value: Any) -> None:
        self._session.edit(f"change {what}", [Put(path, value)], going_on=True)

    def _bound(self, axis: str, ends: tuple[float, float]) -> None:
        self._between(axis, ("world", "bounds", axis), ends)

    def _between(self, name: str, path: tuple[str, ...], ends: tuple[float, float]) -> None:
        if ends[0] < ends[1]:
            self._put(f"bounds of {name}", path, edits.tidy(ends))
        else:
            self._session.edit(f"leave out bounds of {name}", [Drop(path)])

    def _take_machine(self, name: str) -> None:
        if name != OWN:
            values = self._session.text.values
            self._session.edit(f"take {name}", edits.choose_machine(values, name))

    def _take_planner(self, name: str) -> None:
        shared = [setting.name for setting in shared_settings()]
        values = self._session.text.values
        self._session.edit(f"plan by {name}", edits.choose_planner(values, name, shared))

    def _weigh(self) -> None:
        weights = {kind: float(handle.value) for kind, handle in self._costs.items()}
        self._session.edit("weigh the cost", edits.choose_objective(weights), going_on=True)


def _known(planner: str) -> str:
    return planner if planner in planners.names() else planners.names()[0]


def _limits(problem: PlanningTask) -> dict[str, tuple[float, float]]:
    """Return the limits of inputs and states by their names, where there are two."""
    model = problem.model
    rows = [*model.control_bounds.tolist(), *problem.bounds.tolist()]
    named = zip((*model.control_names, *model.state_names), rows, strict=True)
    workspace = problem.scenario.world.bounds
    return {
        name: (low, high)
        for name, (low, high) in named
        if math.isfinite(high - low) and name not in workspace
    }


def _parameters(problem: PlanningTask) -> list[tuple[str, float, str]]:
    """Return the machine's parameters with values and units."""
    units = {p.name: p.unit for p in problem.system.parameters}
    return [(name, float(value), units[name]) for name, value in problem.machine.parameters]
