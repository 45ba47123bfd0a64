"""File: the scenario is opened, saved and read as text; its plan is exported."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Any

from kinolab.errors import InputError, Mistake
from kinolab.files import write_whole
from kinolab.problem import PlanningTask
from kinolab.scenario import builtin_scenarios
from kinolab.scenario.load import toml_document
from kinolab.solve import PlanResult
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.core.scenario_text import FEWER
from kinolab.studio.scene.page_inputs import on_press
from kinolab.studio.scene.session import Session

Planned = tuple[PlanningTask, PlanResult]
PYTHON = """\
import kinolab

problem = kinolab.load({path})
plan = problem.solve(seed={seed})
print(plan)
kinolab.save_page(problem, plan, {page})
"""
BUILT_IN = "built in: "


class FilePanel:
    """The tab with what is kept.

    Args:
        session: The session.
        planned: Returns the plan that is shown; None where there is none.
    """

    def __init__(self, session: Session, planned: Callable[[], Planned | None]) -> None:
        self._session, self._planned, gui = session, planned, session.server.gui
        self._where = gui.add_markdown("")
        on_press(session, gui.add_button("Save", color="blue"), session.save)
        self._name = gui.add_text("Name", session.path.name)
        on_press(session, gui.add_button("Save under this name"), self._save_as)
        with gui.add_folder("Open"):
            self._file = gui.add_dropdown("Scenario", self._files())
            on_press(session, gui.add_button("Open this scenario"), self._open)
        with gui.add_folder("The text", expand_by_default=False):
            self._toml = gui.add_text("TOML", "", multiline=True)
            on_press(session, gui.add_button("Take over this text"), self._take_over)
            self._python = gui.add_text("Python", "", multiline=True, disabled=True)
        with gui.add_folder("The plan", expand_by_default=False):
            gui.add_markdown("Into the folder runs beside the scenario.")
            for what in ("Run folder", "Page", "Film"):
                on_press(session, gui.add_button(what), partial(self._export, what))
        session.listen(self._listen)

    def _files(self) -> tuple[str, ...]:
        built_in = (f"{BUILT_IN}{name}" for name in builtin_scenarios())
        return (*self._session.folder.scenarios(), *built_in)

    def _listen(self, meaning: ScenarioMeaning) -> None:
        session = self._session
        saved = "saved" if session.text.text == session.text.saved else "**not saved yet**"
        self._where.content = f"`{session.path.name}` in `{session.folder.root}`: {saved}"
        self._toml.value = session.text.text
        seed = 1 if meaning.problem is None else meaning.problem.scenario.planner.seed
        page = json.dumps(f"{session.path.stem}.html")
        self._python.value = PYTHON.format(path=json.dumps(session.path.name), seed=seed, page=page)
        if self._file.options != (files := self._files()):
            self._file.options = files

    def _save_as(self) -> None:
        name = (
            self._name.value if self._name.value.endswith(".toml") else f"{self._name.value}.toml"
        )
        path = self._session.folder.path(name)
        if path.exists() and path != self._session.path:
            what = "this file is there already."
            raise InputError([Mistake(name, what, "Choose another name, or open it.")])
        self._session.path = path
        self._session.save()

    def _open(self) -> None:
        name, folder = self._file.value, self._session.folder
        if name.startswith(BUILT_IN):
            path = folder.copy_builtin(name.removeprefix(BUILT_IN))
        else:
            path = folder.path(name)
        self._session.open(path)
        self._name.value = path.name

    def _take_over(self) -> None:
        text = self._toml.value
        toml_document(text, self._session.path.name, FEWER)  # what is not TOML is not taken over
        self._session.write("change the text", text)

    def _export(self, what: str) -> None:
        planned = self._planned()
        if planned is None or planned[1].trajectory is None:
            raise InputError([Mistake(what, "there is no plan yet.", "Search for one first.")])
        folder = self._session.folder.path(f"runs/{self._session.path.stem}")
        folder.mkdir(parents=True, exist_ok=True)
        write: dict[str, Callable[..., Any]] = {
            "Run folder": _write_run,
            "Page": _write_page,
            "Film": _write_film,
        }
        name = write[what](folder, *planned)
        self._session.tell(f"{what} written", f"runs/{self._session.path.stem}/{name}")


def _write_run(folder: Any, problem: PlanningTask, plan: PlanResult) -> str:
    from kinolab.runs import require_place, write_run

    require_place(folder)
    write_run(folder, problem, plan)
    return ""


def _write_page(folder: Any, problem: PlanningTask, plan: PlanResult) -> str:
    from kinolab.show.view import save_page

    return str(save_page(problem, plan, folder / "page.html").name)


def _write_film(folder: Any, problem: PlanningTask, plan: PlanResult) -> str:
    from kinolab.show.film.animation import animate

    assert plan.trajectory is not None
    write_whole(folder / "film.gif", animate(problem, plan.trajectory))
    return "film.gif"
