"""Pose: where the machine starts and where it shall go, by sliders and by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.dynamics.model.units import state_units
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import to_matrices
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import TOLERANCE
from kinolab.studio.core import edits
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.core.pose_edits import asked, with_body_at, with_entry, written
from kinolab.studio.core.scenario_text import Change, Put
from kinolab.studio.scene.gizmo import Gizmo, size_in
from kinolab.studio.scene.page_inputs import on_hand, show
from kinolab.studio.scene.scene_nodes import wxyz_of
from kinolab.studio.scene.session import Session

ENDS = {"Start": "start", "Goal": "goal"}
SEVERAL = "This scenario has several goals: change them in its text, under File."


class PosePanel:
    """The tab in which start and goal are set."""

    def __init__(self, session: Session) -> None:
        self._session, gui = session, session.server.gui
        self._problem: PlanningTask | None = None
        self._rows: dict[str, tuple[Any, Any, Any]] = {}  # slider, whether asked, tolerance
        self._made: Any = None
        self._which = on_hand(
            session,
            gui.add_dropdown("Pose of the", tuple(ENDS), initial_value="Start"),
            lambda _: self._again(),
        )
        self._by_hand = on_hand(
            session,
            gui.add_checkbox("Drag it by a gizmo", True),
            lambda _: self._show(),
        )
        self._words = gui.add_markdown("")
        self._folder = gui.add_folder("Coordinates")
        self._rates = gui.add_folder("Velocities", expand_by_default=False)
        self._parts: list[Any] = []
        self._gizmo = Gizmo(session, "/gizmo/machine", self._dragged)
        session.listen(self._listen)
        session.on_choice(self._chosen)

    @property
    def _end(self) -> str:
        return ENDS[self._which.value]

    def _listen(self, meaning: ScenarioMeaning) -> None:
        if meaning.problem is None or meaning.stale:
            return
        self._problem = meaning.problem
        model = self._problem.model
        made = (self._which.value, self._problem.machine.name, model.state_names, self._several)
        if made != self._made:
            self._made = made
            self._build()
        self._show()

    @property
    def _several(self) -> bool:
        return not isinstance(self._session.text.values.get("goal", {}), dict)

    def _again(self) -> None:
        """Show the other end, with the gizmo at the machine."""
        self._made = None
        self._session.choose(None)
        self._listen(self._session.meaning)

    def _chosen(self, number: int | None) -> None:
        """Leave the scene to the gizmo of an obstacle."""
        if number is not None:
            self._gizmo.hide()
        else:
            self._show()

    def _state(self) -> Array:
        """Return the pose that is shown, shape (nx,)."""
        assert self._problem is not None
        start = self._problem.start
        return start if self._end == "start" else self._problem.goal.centre(start)

    def _build(self) -> None:
        """Make the inputs anew, for another machine or the other end."""
        problem = self._problem
        assert problem is not None
        for part in self._parts:
            part.remove()
        self._parts, self._rows = [], {}
        goal = self._end == "goal"
        self._words.content = SEVERAL if goal and self._several else ""
        if goal and self._several:
            return
        model = problem.model
        turned = {k for part in model.space.spheres for k in part.entries}
        for k, name in enumerate(model.state_names):
            if k not in turned and k != problem.cost_entry:
                with self._folder if k < model.nq else self._rates:
                    self._row(name, state_units(model)[k], k, goal)

    def _row(self, name: str, unit: str, k: int, goal: bool) -> None:
        gui, session, problem = self._session.server.gui, self._session, self._problem
        assert problem is not None
        label = f"{name} [{unit}]" if unit else name
        low, high = problem.sampling_bounds[k].tolist()
        value = float(self._state()[k])
        ends = min(low, value), max(high, value)
        step = 10.0 ** math.floor(math.log10(max(ends[1] - ends[0], 1e-6) / 500))  # of a slider
        row = gui.add_folder(None)
        self._parts.append(row)
        with row:
            asks = within = None
            if goal:
                asks = on_hand(
                    session,
                    gui.add_checkbox(f"ask for {name}", name in self._asked()),
                    lambda wanted: self._ask(name, wanted),
                )
            slider = on_hand(
                session,
                gui.add_slider(label, ends[0], ends[1], step, value),
                lambda v: self._slid(name, float(v)),
            )
            if goal:
                within = on_hand(
                    session,
                    gui.add_number(f"within ± {unit}".rstrip(), TOLERANCE, min=1e-6, step=0.01),
                    lambda v: self._within(name, float(v)),
                )
        self._rows[name] = (slider, asks, within)

    def _asked(self) -> list[str]:
        return edits.goal_entries(self._session.text.values.get("goal", {}))

    def _show(self) -> None:
        """Show the pose in all inputs, and the gizmo at it."""
        problem = self._problem
        if problem is None:
            return
        state, names = self._state(), problem.model.state_names
        section = problem.scenario.goal
        wanted = [] if self._several else self._asked()
        for name, (slider, asks, within) in self._rows.items():
            show(slider, float(np.clip(state[names.index(name)], slider.min, slider.max)))
            if asks is not None:
                show(asks, name in wanted)
                show(within, float(section.tolerance_of(name)))
                slider.visible = within.visible = name in wanted
        if self._session.chosen is not None or not self._by_hand.value:
            self._gizmo.hide()
            return
        points = problem.scenario.goal.point
        if self._end == "goal" and points and not self._several:
            self._gizmo.show(points[0].position, size=size_in(self._session, 0.0))
        elif self._end == "start" or (wanted and not self._several):
            pose = problem.frames(state)[problem.leading].reshape(3, 4)
            self._gizmo.show(pose[:, 3], wxyz_of(pose[:, :3]), size=size_in(self._session, 0.0))
        else:
            self._gizmo.hide()

    def _write(self, what: str, state: Array, *, going_on: bool) -> None:
        """Write how a pose differs from the one that is shown."""
        assert self._problem is not None
        changes = written(self._problem, self._state(), state)
        if self._end == "goal":
            changes = asked(self._problem, changes)
        self._session.edit(what, edits.set_state(self._end, changes), going_on=going_on)

    def _slid(self, name: str, value: float) -> None:
        assert self._problem is not None
        if self._session.chosen is not None:
            self._session.choose(None)  # the gizmo is the machine's from now on
        state = with_entry(self._problem, self._state(), name, value)
        self._write(f"{self._end}: {name}", state, going_on=True)

    def _ask(self, name: str, wanted: bool) -> None:
        assert self._problem is not None
        value = round(float(self._state()[self._problem.model.state_names.index(name)]), 4)
        tolerance = self._problem.scenario.goal.tolerance_of(name) if wanted else None
        values = self._session.text.values
        self._session.edit(f"ask for {name}", edits.ask(values, name, value, tolerance))

    def _within(self, name: str, tolerance: float) -> None:
        values = self._session.text.values
        value = values.get("goal", {}).get(name, 0.0)
        changes = edits.ask(values, name, value, tolerance)
        self._session.edit(f"tolerance of {name}", changes, going_on=True)

    def _dragged(self, place: Array, wxyz: Array, over: bool) -> None:
        problem = self._problem
        if problem is None:
            return
        points = problem.scenario.goal.point
        if self._end == "goal" and points:
            if over:
                path = ("goal", "point", 0, "position")
                change: Change = Put(path, edits.tidy(place))
                self._session.edit("move the target", [change])
            return
        turn = to_matrices(np.roll(wxyz, -1))
        state = with_body_at(problem, self._state(), problem.leading, place, turn)
        if self._end == "start":
            self._session.scene.pose(state)
        if over:
            self._write(f"drag the {self._end}", state, going_on=False)
            self._show()
