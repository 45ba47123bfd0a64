"""Machine: the Python file of the machine is changed beside the scene, and seen at once."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

from kinolab.errors import InputError, Mistake
from kinolab.scenario.starters.starter_files import STARTERS, write_starter
from kinolab.studio.core.background_work import BackgroundWork, Ended, Told
from kinolab.studio.core.chosen_folder import autosave
from kinolab.studio.core.machine_task import Examined, examine_machine
from kinolab.studio.core.machine_text import (
    machine_file,
    own_copy,
    read_machine,
    registered_name,
    write_machine,
)
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.core.scenario_text import ScenarioText
from kinolab.studio.scene.page_inputs import on_hand, on_press
from kinolab.studio.scene.session import Session

WIDTH = 500.0  # [pixel] of the editor, where the scene is at least twice as wide
RIGHTS = "It is a program: it runs as you, on this computer, and may do whatever you may."
OTHERS = "This machine comes from kinolab. To change it, take a copy of its file."
NO_FILE = "This machine has no Python file: a scenario's machines, or a file of another tool."


class MachinePanel:
    """The tab about the machine, and the editor of its file on the other side of the scene.

    Args:
        session: The session.
        look: Called when the scene has become narrower or wider.
    """

    def __init__(self, session: Session, look: Callable[[], None]) -> None:
        self._session, self._refit, gui = session, look, session.server.gui
        self._path: Path | None = None
        self._good = ""  # the last text that was a machine
        self._taken = ""  # the text that was taken over last
        self._work: BackgroundWork | None = None
        self._whose = gui.add_markdown("")
        self._edit = on_press(
            session, gui.add_button("Edit this machine", color="blue"), self._open
        )
        self._look = on_press(
            session, gui.add_button("Equations and laws", hint="As `plan examine` has them."),
            self._examine,
        )  # fmt: skip
        self._verdict = gui.add_markdown("")
        with gui.add_folder("A new machine"):
            gui.add_markdown("A machine and a scenario, commented, to start from.")
            self._kind = gui.add_dropdown("Template", STARTERS)
            self._name = gui.add_text("Name", "my_machine")
            on_press(session, gui.add_button("Begin with it"), self._begin)
        self._panel = gui.add_panel(visible=False)
        with self._panel.add_tab("Machine"):
            self._where = gui.add_markdown("")
            self._text = on_hand(session, gui.add_text("Machine", "", multiline=True), self._typed)
            on_press(session, gui.add_button("Take over (Ctrl-Enter)", color="blue"), self._take)
            self._back = on_press(session, gui.add_button("Back to what worked"), self._go_back)
            on_press(session, gui.add_button("Close the editor"), self._close_editor)
            self._told = gui.add_html("")
        with self._panel.add_tab("Equations"):
            self._equations = gui.add_markdown("")
        with self._panel.add_tab("Laws"):
            self._laws = gui.add_markdown("")
        session.listen(self._listen)

    def close(self) -> None:
        """End what is running."""
        if self._work is not None:
            self._work.close()

    def _listen(self, meaning: ScenarioMeaning) -> None:
        session = self._session
        if meaning.stale and meaning.mistakes and self._path is None:
            return
        try:
            path = machine_file(session.folder, session.text.values)
        except InputError:
            return  # what is wrong with it is told above the panels
        if path != self._path:
            self._show(path)
        named = registered_name(session.text.values)
        self._whose.content = (
            f"`{path.name}` describes it." if path else OTHERS if named else NO_FILE
        )
        self._edit.label = "Edit this machine" if path else "Edit a copy of this machine"
        self._edit.disabled = not (path or named)
        self._look.disabled = meaning.problem is None or meaning.stale
        self._tell(meaning)

    def _tell(self, meaning: ScenarioMeaning) -> None:
        """Say in the editor whether its text is a machine, or what is wrong with it, and where."""
        if not meaning.stale:
            self._good = self._taken
            self._told.content = ""
            return
        words = "\n".join(str(mistake) for mistake in meaning.mistakes)
        kept = "The last machine without a mistake is shown.\n" if meaning.problem else ""
        self._told.content = f'<div class="kl-wrong">{escape(kept + words)}</div>' if words else ""

    def _show(self, path: Path | None) -> None:
        """Show another file, with what was typed into it and never taken over."""
        self._path, self._verdict.content = path, ""
        self._equations.content = self._laws.content = "Press *Equations and laws*."
        self._panel.visible = False
        if path is None:
            return
        self._taken = self._good = read_machine(path)
        self._text.value = self._taken
        self._where.content = f"`{path.name}`. {RIGHTS}"
        if (kept := autosave(path)).is_file():
            self._text.value = read_machine(kept)
            self._session.tell("What was not taken over is here again", path.name)

    def _open(self) -> None:
        session = self._session
        if self._path is None:
            name = registered_name(session.text.values)
            changes = own_copy(session.folder, name)
            session.edit(f"take a copy of {name}", changes)
            self._show(machine_file(session.folder, session.text.values))
        if self._panel.visible:
            return
        self._panel.visible = True
        widths = [client.camera.image_width for client in session.server.get_clients().values()]
        # half of the narrowest scene, and not less than 300 [pixel]
        self._panel.dock_left()
        self._panel.set_width(max(300.0, min([WIDTH, *(0.5 * width for width in widths)])))
        self._refit()

    def _close_editor(self) -> None:
        self._panel.visible = False
        self._refit()

    def _typed(self, text: str) -> None:
        """Keep what is typed beside the file, until it is taken over."""
        if self._path is not None:
            self._session.folder.autosave(self._path, ScenarioText(text, self._taken))

    def _take(self) -> None:
        if self._path is None:
            return
        self._taken = self._text.value
        write_machine(self._path, self._taken)
        autosave(self._path).unlink(missing_ok=True)
        self._session.understand_again()

    def _go_back(self) -> None:
        self._text.value = self._good
        self._take()

    def _begin(self) -> None:
        """Write a template's machine and scenario, and open them."""
        folder, name = self._session.folder, self._name.value.strip()
        path = folder.path(f"{name}.toml")
        write_starter(name, folder.root, self._kind.value)
        self._session.open(path)
        self._path = None
        self._show(folder.path(f"{name}.py"))
        self._open()

    def _examine(self) -> None:
        problem = self._session.meaning.problem
        if problem is None:
            raise InputError([Mistake("machine", "there is none yet.", "Mend what is told above.")])
        if self._work is not None:
            self._work.close()
        self._verdict.content = "Getting ready …"
        self._work = BackgroundWork(
            examine_machine,
            (problem,),
            lambda message: self._session.attempt(lambda: self._heard(message)),
        )

    def _heard(self, message: Any) -> None:
        if isinstance(message, Told):
            self._verdict.content = f"{message.words} …"
        elif isinstance(message, Ended):
            found: Examined | None = message.result
            if found is None:
                self._verdict.content = f"**{message.failure}**"
                return
            self._verdict.content = f"**{found.verdict}** More in the tabs beside the editor."
            self._equations.content = f"```\n{found.equations}\n```"
            self._laws.content = f"```\n{found.told}\n```"
            self._open()
