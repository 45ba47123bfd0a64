"""Try it: a plan is executed under disturbances, proved, driven by keys, and compared."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from kinolab.analyze.execute.conditions import Conditions
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from kinolab.studio.core.background_work import BackgroundWork, Ended, Told
from kinolab.studio.core.trial_tasks import (
    Executed,
    Proved,
    execute_plan,
    path_of,
    prove_plan,
)
from kinolab.studio.panels.plan_panel import PlanPanel
from kinolab.studio.scene.page_inputs import on_hand, on_press
from kinolab.studio.scene.session import Session

NONE = "(none)"
COLORS = {  # of paths, by how a run ended
    "reached": (42, 125, 225),
    "missed": (224, 160, 0),
    "collided": (214, 39, 40),
    "strayed": (227, 119, 194),
    "lost": (123, 50, 148),
}
OTHER = (235, 120, 20)  # the path of the plan that is kept to be compared
TUBE = (60, 160, 90)
DRIVE = "drive"  # the page in which one drives
LINK = (
    '<div style="padding: 0 10px 8px"><a href="{name}" target="_blank">Open the page</a>, '
    "then press <b>m</b> and drive by the arrow keys.</div>"
)


class TrialPanel:
    """What is below the plan in its tab: whether it holds for machines that differ.

    Args:
        session: The session.
        planner: The panel that has the plan.
    """

    def __init__(self, session: Session, planner: PlanPanel) -> None:
        self._session, self._planner, gui = session, planner, session.server.gui
        self._work: BackgroundWork | None = None
        self._kept: tuple[PlanningTask, PlanResult] | None = None
        self._failed: dict[str, Array] = {}
        with gui.add_folder("Try the plan", expand_by_default=False):
            gui.add_markdown("Machines that differ from the plan's, with feedback along it.")
            self._parameters = gui.add_number("Parameters ± %", 5.0, min=0.0, max=99.0, step=1.0)
            self._noise = gui.add_number(
                "Sensors ± %", 0.0, min=0.0, max=99.0, step=0.5,
                hint="Standard deviation, of each state's scale; not asked by Prove.",
            )  # fmt: skip
            self._disturbance = gui.add_number(
                "Inputs ± %", 0.0, min=0.0, max=99.0, step=0.5,
                hint="Standard deviation in each step, of each input's range; not asked by Prove.",
            )  # fmt: skip
            self._runs = gui.add_number("Runs", 100, min=1, max=1000, step=1)
            on_press(session, gui.add_button("Execute it", color="blue"), self._execute)
            on_press(
                session,
                gui.add_button("Prove it", hint="For all machines within the first bound."),
                self._prove,
            )
            self._stop = on_press(session, gui.add_button("Stop trying", visible=False), self._end)
            self._told = gui.add_markdown("")
            self._run = on_hand(
                session, gui.add_dropdown("Run that failed", (NONE,), visible=False), self._look_at
            )
        with gui.add_folder("Compare", expand_by_default=False):
            on_press(session, gui.add_button("Keep this plan to compare"), self._keep)
            on_press(session, gui.add_button("Forget it"), self._forget)
            self._table = gui.add_markdown("The next plan is then shown beside it.")
        with gui.add_folder("Drive it yourself", expand_by_default=False):
            on_press(session, gui.add_button("Make the page"), self._drive)
            self._link = gui.add_html("")
        planner.on_plan(self._changed)

    def close(self) -> None:
        """End what is running."""
        if self._work is not None:
            self._work.close()

    def _plan(self) -> tuple[PlanningTask, PlanResult]:
        plan = self._planner.plan
        if plan is None or plan[1].trajectory is None:
            raise InputError([Mistake("plan", "there is none yet.", "Search for one first.")])
        return plan

    def _changed(self) -> None:
        """Take away what was said of an earlier plan."""
        self.close()
        self._clear()
        self._told.content = ""
        self._compare()

    def _clear(self) -> None:
        self._stop.visible = self._run.visible = False
        for name in (*COLORS, "tube"):
            self._session.scene.remove(f"/plan/{name}")

    def _begin(self, task: Any, *given: Any) -> None:
        problem, plan = self._plan()
        self.close()
        self._clear()
        self._told.content, self._stop.visible = "Getting ready …", True
        session = self._session
        self._work = BackgroundWork(
            task,
            (problem, plan.trajectory, *given),
            lambda message: session.attempt(lambda: self._heard(message)),
        )

    def _execute(self) -> None:
        percents = (self._parameters, self._noise, self._disturbance)
        parameters, noise, disturbance = (0.01 * float(each.value) for each in percents)
        conditions = Conditions(parameters, noise, disturbance)
        self._begin(execute_plan, conditions, int(self._runs.value), 1)

    def _prove(self) -> None:
        self._begin(prove_plan, float(self._parameters.value))

    def _end(self) -> None:
        if self._work is not None:
            self._work.end()

    def _heard(self, message: Any) -> None:
        if isinstance(message, Told):
            self._told.content = f"{message.words} …"
            return
        assert isinstance(message, Ended)
        self._stop.visible = False
        if message.result is None:
            self._told.content = f"**{message.failure}**"
            return
        first, *others = map(_in_the_page, message.result.lines)
        self._told.content = "\n".join([f"**{first}**", "", *(f"- {line}" for line in others)])
        if isinstance(message.result, Executed):
            self._show_runs(message.result)
        elif isinstance(message.result, Proved):
            self._session.scene.boxes("/plan/tube", message.result.low, message.result.high, TUBE)

    def _show_runs(self, found: Executed) -> None:
        for how, segments in found.paths.items():
            self._session.scene.lines(f"/plan/{how}", segments, COLORS[how], 1.5)
        self._failed = dict(found.failed)
        self._run.options = (NONE, *self._failed)
        self._run.value, self._run.visible = NONE, bool(self._failed)

    def _look_at(self, name: str) -> None:
        """Put the machine where a run ended that failed."""
        if name in self._failed:
            self._session.scene.pose(self._failed[name][-1])

    def _keep(self) -> None:
        self._kept = self._plan()
        self._compare()

    def _forget(self) -> None:
        self._kept = None
        self._session.scene.remove("/plan/other")
        self._table.content = "The next plan is then shown beside it."

    def _compare(self) -> None:
        """Draw the path of the plan that was kept, and say how the two differ."""
        if self._kept is None:
            return
        problem, kept = self._kept
        assert kept.trajectory is not None
        self._session.scene.lines("/plan/other", path_of(problem, kept.trajectory.x), OTHER, 3.0)
        now = self._planner.plan
        columns = [_facts(*self._kept)]
        columns += [_facts(*now)] if now is not None and now[1].trajectory is not None else []
        heads = ["kept (orange)", "now (blue)"][: len(columns)]
        names = [name for name in columns[0] if any(column[name] for column in columns)]
        rows = [f"| {name} | {' | '.join(c[name] for c in columns)} |" for name in names]
        head = [f"| | {' | '.join(heads)} |", f"|---|{'---|' * len(heads)}"]
        self._table.content = "\n".join([*head, *rows])

    def _drive(self) -> None:
        """Make the interactive page of the plan, or of the problem, and show where it is."""
        from kinolab.show.page.document import page_html
        from kinolab.show.scene.scenes import content_of_plan

        problem, plan = self._planner.plan or (self._session.meaning.problem, None)
        if problem is None:
            raise InputError([Mistake("drive", "there is no machine yet.", "See above.")])
        self._link.content = '<div style="padding: 0 10px 8px">Making the page …</div>'
        shown = plan if plan is not None and plan.trajectory is not None else None
        self._session.pages[DRIVE] = page_html(content_of_plan(problem, shown)).encode()
        self._link.content = LINK.format(name=DRIVE)


def _in_the_page(line: str) -> str:
    """Return what the command line says in the words of the page, which has no options."""
    line = re.sub(r"--keep (\w+(?:,\w+)*)", r"\1 as in the plan", line)
    return re.sub(r"--large (\S+) instead of \S+", r"feedback that is stiffer (\1)", line)


def _facts(problem: PlanningTask, plan: PlanResult) -> dict[str, str]:
    """Return what two plans are compared by."""
    motion, certificate = plan.trajectory, plan.certificate
    assert motion is not None
    length = float(np.linalg.norm(np.diff(path_of(problem, motion.x), axis=1), axis=2).sum())
    margin = None if certificate is None else certificate.margin
    return {
        "duration": f"{motion.duration:.3g} s",
        "way": f"{length:.3g} m",
        "cost": "" if plan.price is None else f"{plan.price:.4g}",
        "clearance": ""
        if margin is None
        else f"{1000.0 * (margin.clearance + margin.required):.3g} mm",
        "verified": "yes" if certificate is not None and certificate.passed else "no",
        "planner": plan.planner,
        "seed": str(plan.seed),
        "search": f"{plan.timings.get('search', 0.0):.2f} s",
    }
