"""The page of the studio: what is wrong above, the panels below, keys for what is done often."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

from viser._messages import HotkeyKey, RunJavascriptMessage

from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.panels.build_panel import BuildPanel
from kinolab.studio.panels.choose_panel import ChoosePanel
from kinolab.studio.panels.file_panel import FilePanel
from kinolab.studio.panels.look_panel import LookPanel
from kinolab.studio.panels.machine_panel import MachinePanel
from kinolab.studio.panels.plan_panel import PlanPanel
from kinolab.studio.panels.pose_panel import PosePanel
from kinolab.studio.panels.trial_panel import TrialPanel
from kinolab.studio.scene.session import Session

KEYS: dict[str, HotkeyKey] = {"Undo": "Z", "Redo": "Y", "Save": "S"}  # with Ctrl or Cmd


class StudioPage:
    """All panels of a session."""

    def __init__(self, session: Session) -> None:
        self._session, gui = session, session.server.gui
        self._title = gui.add_markdown("")
        self._wrong = gui.add_markdown("Getting ready: the machine is compiled …")
        done: dict[str, Callable[[], Any]] = {
            "Undo": session.undo, "Redo": session.redo, "Save": session.save,
        }  # fmt: skip
        often = gui.add_button_group("", tuple(done))
        often.on_click(lambda event: session.attempt(done[event.target.value]))
        self._steps = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Build"):
            BuildPanel(session)
        with tabs.add_tab("Pose"):
            PosePanel(session)
        with tabs.add_tab("Choose"):
            ChoosePanel(session)
        with tabs.add_tab("Machine"):
            self._machine = MachinePanel(session, self._refit)
        with tabs.add_tab("Plan"):
            self._plan = PlanPanel(session)
            self._trials = TrialPanel(session, self._plan)
        with tabs.add_tab("File"):
            FilePanel(session, lambda: self._plan.plan)
        with tabs.add_tab("Look"):
            self._look = LookPanel(session)
        self._look.theme(False)
        for name, key in KEYS.items():
            command = gui.add_command(name, hotkey=key, modifier="cmd/ctrl")
            command.on_trigger(partial(_triggered, session, done[name]))
        script = files(__package__).joinpath("code_areas.js").read_text("utf-8")
        session.server._websock_server.queue_message(RunJavascriptMessage(script))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(400.0)  # [pixel] of the panels
        session.listen(self._listen)
        session.begin()

    def close(self) -> None:
        """End what is running."""
        self._plan.close()
        self._trials.close()
        self._machine.close()
        self._look.close()
        self._session.close()

    def _refit(self) -> None:
        self._look.refit()

    def _listen(self, meaning: ScenarioMeaning) -> None:
        text = self._session.text
        title = text.values.get("title", "") if not meaning.stale else ""
        self._title.content = f"**{title}**" if title else ""
        steps = [f"undo: {text.last}"] * bool(text.last) + [f"redo: {text.next}"] * bool(text.next)
        self._steps.content = f"*{', '.join(steps)}*" if steps else "*nothing to undo*"
        told = [f"- {mistake}" for mistake in meaning.mistakes[:10]]
        if more := len(meaning.mistakes) - 10:
            told += [f"- and {more} more."] if more > 0 else []
        if meaning.stale:
            told = ["**This cannot be understood yet; the last good scene is shown.**", "", *told]
        elif told:
            told = ["**Not possible yet:**", "", *told]
        self._wrong.content = "\n".join(told) if told else "✓ Start and goal are possible."


def _triggered(session: Session, work: Callable[[], Any], _: Any) -> None:
    session.attempt(work)
