"""Plan: the search is watched, stopped and improved; its plan is played, and its proof is shown."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from viser import uplot

from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs.plan_summary import summary
from kinolab.scenario import apply_overrides
from kinolab.show.scene.scenes import told
from kinolab.solve import PlanResult
from kinolab.studio.core.background_work import BackgroundWork, Ended, Told
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.core.scenario_text import Put
from kinolab.studio.core.search_task import Explored, Improved, Searched, search
from kinolab.studio.scene.page_inputs import on_hand, on_press, show
from kinolab.studio.scene.session import Session

FRAME = 1.0 / 30.0  # [s] between two poses while a plan is played
COLORS = ("#3a6ea5", "#c8553d", "#2f8f5b", "#8a5fb0", "#b98d2f", "#4b9aa5", "#a0527a", "#666666")
READY = "Getting ready: what a planner needs is compiled once, for all later searches."


class PlanPanel:
    """The tab in which one plans.

    Attributes:
        plan: The best plan of the last search, with its problem; None before there is one.
    """

    def __init__(self, session: Session) -> None:
        self._session, gui = session, session.server.gui
        self.plan: tuple[PlanningTask, PlanResult] | None = None
        self._search: BackgroundWork | None = None
        self._problem: PlanningTask | None = None
        self._awaited = ""  # the text of a scenario that is searched for when it is understood
        self._playing = False
        self._player: threading.Thread | None = None
        self._search_button = on_press(session, gui.add_button("Search", color="blue"), self._begin)
        self._stop = on_press(session, gui.add_button("Stop", disabled=True), self._end)
        self._improve = on_press(
            session, gui.add_button("Improve further", disabled=True), self._go_on
        )
        self._busy = gui.add_progress_bar(100.0, animated=True, visible=False)
        self._state = gui.add_markdown("Nothing has been planned yet.")
        self._reasons = gui.add_folder("What would help", visible=False)
        self._remedies: list[Any] = []
        self._motion = gui.add_folder("Motion", visible=False)
        with self._motion:
            self._time = on_hand(session, gui.add_slider("Time [s]", 0.0, 1.0, 0.01, 0.0), self._at)
            self._play = on_press(session, gui.add_button("Play"), self._toggle)
            self._speed = gui.add_dropdown("Speed", ("1", "0.25", "0.5", "2", "4", "8"))
        self._proof = gui.add_folder("Certificate", visible=False)
        with self._proof:
            self._checks = gui.add_markdown("")
        self._plots = gui.add_folder("Plots", visible=False, expand_by_default=False)
        self._drawn: list[Any] = []
        self._hearing: list[Callable[[], None]] = []
        session.listen(self._listen)

    def on_plan(self, listener: Callable[[], None]) -> None:
        """Have a function called when another plan is shown, or none."""
        self._hearing.append(listener)

    def close(self) -> None:
        """End what is running."""
        self._playing = False
        if self._player is not None:
            self._player.join()
        if self._search is not None:
            self._search.close()

    def _listen(self, meaning: ScenarioMeaning) -> None:
        self._search_button.disabled = not meaning.ready or self._search is not None
        self._begin_if_awaited()
        if meaning.problem is not self._problem:
            self._problem = meaning.problem
            self._playing = False
            if self.plan is not None and self._search is None:
                self._state.content = "**The scenario has changed** since this plan was found."

    def _begin(self, *, going_on: bool = False) -> None:
        meaning = self._session.meaning
        if self._search is not None:
            return
        if not meaning.ready or meaning.problem is None:
            what = "start and goal are not possible yet."
            raise InputError([Mistake("search", what, "See above what is wrong with them.")])
        guess = self.plan[1].trajectory if going_on and self.plan is not None else None
        self._running(meaning.problem)
        self._playing = False
        self._session.scene.tree(None)
        self._hide_reasons()
        if not going_on:
            self._show_plan(None)
        problem = self._problem = meaning.problem
        improve = 10.0 if going_on else None  # [s] of further work on a plan
        self._search = BackgroundWork(
            search,
            (problem, guess, improve),
            lambda message: self._session.attempt(lambda: self._heard(problem, message)),
        )

    def _running(self, problem: PlanningTask | None) -> None:
        busy = problem is not None
        self._search_button.disabled = busy
        self._stop.disabled, self._busy.visible = not busy, busy
        self._improve.disabled = busy or self.plan is None or self.plan[1].status != "solved"
        if busy:
            self._state.content = READY

    def _end(self) -> None:
        if self._search is not None:
            self._search.end()
            self._state.content = "Stopping …"

    def _go_on(self) -> None:
        self._begin(going_on=True)

    def _heard(self, problem: PlanningTask, message: Any) -> None:
        """Show what a search tells."""
        if isinstance(message, Told):
            self._state.content = message.words
        elif isinstance(message, Explored):
            self._session.scene.tree(message.segments)
        elif isinstance(message, Improved):
            self._show_plan((problem, message.plan))
        elif isinstance(message, Ended):
            self._search = None
            found: Searched | None = message.result
            if found is not None and found.plan.trajectory is not None:
                self._show_plan((problem, found.plan))
            self._running(None)
            self._search_button.disabled = not self._session.meaning.ready
            if found is None:
                self._state.content = f"**{message.failure}**"
            else:
                self._state.content = _listed(summary(problem, found.plan))
                self._show_reasons(found)

    def _show_plan(self, plan: tuple[PlanningTask, PlanResult] | None) -> None:
        self.plan = plan
        for listener in self._hearing:
            self._session.attempt(listener)
        found = None if plan is None else plan[1]
        motion = None if found is None else found.trajectory
        shown = plan is not None and motion is not None
        self._motion.visible = self._plots.visible = shown
        certificate = None if found is None else found.certificate
        self._proof.visible = certificate is not None
        for part in self._drawn:
            part.remove()
        self._drawn = []
        if plan is None or motion is None:
            if self._problem is not None:
                self._session.scene.plan(self._problem, None)
            return
        problem = plan[0]
        self._session.scene.plan(problem, motion)
        self._time.max = max(float(motion.duration), 0.01)
        show(self._time, 0.0)
        if certificate is not None:
            rows = [
                f"| {'✓' if check.passed else '✗'} | {check.name} | {check.value:.3g} | "
                f"{check.limit:.3g} |"
                for check in certificate.checks
            ]
            head = ["| | check | worst | allowed |", "|---|---|---|---|"]
            margin = "" if certificate.margin is None else f"\n\n{certificate.margin}"
            self._checks.content = "\n".join([*head, *rows]) + margin
        with self._plots:
            self._drawn = list(self._curves(problem, plan[1]))

    def _curves(self, problem: PlanningTask, plan: PlanResult) -> Iterator[Any]:
        """Draw the quantities that page and film plot."""
        assert plan.trajectory is not None
        motion, gui = unwrapped(problem, plan.trajectory), self._session.server.gui
        rows = np.unique(np.linspace(0, len(motion.t) - 1, 400).astype(int))  # of a curve in a plot
        for series in told(problem, motion)[:4]:  # groups of quantities
            which = range(len(series.names)) if series.first is None else series.first
            values = series.values[np.minimum(rows, len(series.values) - 1)]
            labels = [
                f"{n} [{u}]" if u else n for n, u in zip(series.names, series.units, strict=True)
            ]
            curves = [
                uplot.Series(label=labels[k], stroke=COLORS[i % len(COLORS)], width=2)
                for i, k in enumerate(which)
            ]
            yield gui.add_uplot(
                (motion.t[rows], *(np.ascontiguousarray(values[:, k]) for k in which)),
                (uplot.Series(label="t [s]"), *curves),
                title=series.title,
                scales={"x": uplot.Scale(time=False), "y": uplot.Scale(auto=True)},
                aspect=1.6,
            )

    def _at(self, t: float) -> None:
        """Put the machine where it is at a time in [s]."""
        if self.plan is not None and self.plan[1].trajectory is not None:
            self._session.scene.pose(self.plan[1].trajectory.at(np.array([t])).x[0])

    def _toggle(self) -> None:
        self._playing = not self._playing
        self._play.label = "Pause" if self._playing else "Play"
        if self._playing:
            self._player = threading.Thread(target=self._run, daemon=True)
            self._player.start()

    def _run(self) -> None:
        """Play the plan from where the slider stands to its end."""
        t = 0.0 if self._time.value >= self._time.max - FRAME else float(self._time.value)
        before = time.monotonic()
        while self._playing and self.plan is not None and t < self._time.max:
            time.sleep(FRAME)
            now = time.monotonic()
            t, before = min(t + (now - before) * float(self._speed.value), self._time.max), now
            with self._session.server.atomic():
                self._time.value = t
                self._at(t)
        self._playing = False
        self._play.label = "Play"

    def _hide_reasons(self) -> None:
        for part in self._remedies:
            part.remove()
        self._remedies, self._reasons.visible = [], False

    def _show_reasons(self, found: Searched) -> None:
        """Say why nothing was found, with what would help as buttons."""
        gui, session, plan = self._session.server.gui, self._session, found.plan
        if plan.status == "solved" or plan.interrupted:
            return
        # 4 times as long a search, or as much work, as before
        seconds = round(4.0 * session.meaning.problem.scenario.planner.time_limit, 1)  # type: ignore[union-attr]
        self._reasons.visible = True
        with self._reasons:
            text = gui.add_markdown("\n".join(f"- {sentence}" for sentence in found.sentences))
            self._remedies.append(text)
            for change in (*found.changes, f"planner.time_limit={seconds:g}"):
                button = gui.add_button(f"Take {change.replace('=', ' = ', 1)} and search")
                on_press(session, button, partial(self._remedy, change))
                self._remedies.append(button)

    def _remedy(self, change: str) -> None:
        """Write a change that helps, and search as soon as it is understood."""
        values: dict[str, Any] = self._session.text.values
        (override,), mistakes = apply_overrides(values, [change])
        if mistakes:
            raise InputError(mistakes)
        value: Any = values
        for key in override.path:
            value = value[key]
        self._session.edit(f"take {change}", [Put(override.path, value)])
        self._awaited = self._session.text.text
        self._begin_if_awaited()

    def _begin_if_awaited(self) -> None:
        """Search for what a remedy has made of the scenario, once that is understood."""
        meaning = self._session.meaning
        if meaning.text == self._awaited and meaning.ready:
            self._awaited = ""
            self._begin()


def _listed(text: str) -> str:
    """Return lines as a list, the first one in bold, in the words of the page."""
    text = re.sub(r"--set planner.improve=\S+( goes on)?", "Improve further goes on", text)
    first, *others = [line.strip() for line in text.splitlines() if line.strip()]
    return "\n".join([f"**{first}**", "", *(f"- {line}" for line in others)])
