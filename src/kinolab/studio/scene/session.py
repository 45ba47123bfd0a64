"""What is open in the studio: a scenario's text, what it means, its picture, and its search."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import viser

from kinolab.errors import KinolabError
from kinolab.studio.core.chosen_folder import ChosenFolder
from kinolab.studio.core.meaning import ScenarioMeaning, meaning_of
from kinolab.studio.core.scenario_text import Change
from kinolab.studio.scene.scene_nodes import SceneNodes

Listener = Callable[[ScenarioMeaning], None]


class Session:
    """A scenario that is open; all tabs of the browser see the same one.

    Args:
        server: Shows it.
        folder: In which it works.
        path: Of the scenario's file, which need not be there yet.
        new: The text of one that is not there.
        pages: Of the server, to which others may be added.

    Attributes:
        pages: What the server answers beside the studio's own page, by its name.
        text: The scenario's text, with its history.
        meaning: What it meant when it was last understood.
        scene: Its picture.
        chosen: The number of the obstacle that is edited; None for none.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        folder: ChosenFolder,
        path: Path,
        new: str = "",
        pages: dict[str, bytes] | None = None,
    ) -> None:
        self.pages = {} if pages is None else pages
        self.server, self.folder, self.path = server, folder, path
        self.text, unsaved = folder.open(path)
        if not self.text.text:
            self.text.write("a new scenario", new)
        self.meaning = ScenarioMeaning("")
        self.chosen: int | None = None
        self._choosing: list[Callable[[int | None], None]] = []
        self.scene = SceneNodes(server, self.choose)
        self._listeners: list[Listener] = []
        self._lock, self._news = threading.RLock(), threading.Event()
        self._over = self._anew = False
        self._thread = threading.Thread(target=self._understand, daemon=True)
        if unsaved:
            self.tell("What was not saved is here again", "Undo goes back to the file.")

    def begin(self) -> None:
        """Begin to understand the text, once all panels listen."""
        self._thread.start()
        self._news.set()

    def close(self) -> None:
        """End it; what is not saved is kept beside the file."""
        self._over = True
        self._news.set()
        self._thread.join()

    def listen(self, listener: Listener) -> None:
        """Have a function called with every new meaning."""
        self._listeners.append(listener)

    def on_choice(self, listener: Callable[[int | None], None]) -> None:
        """Have a function called when another obstacle is chosen."""
        self._choosing.append(listener)

    def choose(self, number: int | None) -> None:
        """Choose an obstacle to be edited, or none."""
        self.chosen = number
        for listener in self._choosing:
            self.attempt(partial(listener, number))

    def edit(self, what: str, changes: Sequence[Change], *, going_on: bool = False) -> None:
        """Change the text; what it means is found in the background.

        Raises:
            InputError: If it cannot be changed so.
        """
        with self._lock:
            if self.text.edit(what, changes, going_on=going_on):
                self._changed()

    def write(self, what: str, text: str) -> None:
        """Replace the text as a whole."""
        with self._lock:
            if self.text.write(what, text):
                self._changed()

    def undo(self) -> None:
        """Take the last edit back."""
        with self._lock:
            if self.text.undo():
                self._changed()

    def redo(self) -> None:
        """Do again what was undone last."""
        with self._lock:
            if self.text.redo():
                self._changed()

    def save(self) -> None:
        """Write the file."""
        with self._lock:
            self.folder.save(self.path, self.text)
            self._news.set()
        self.tell("Saved", self.path.name)

    def open(self, path: Path) -> None:
        """Open another scenario.

        Raises:
            InputError: If it cannot be read.
        """
        text, unsaved = self.folder.open(path)
        with self._lock:
            self.text, self.path = text, path
            self.choose(None)
            self.meaning = ScenarioMeaning("")
            self._news.set()
        if unsaved:
            self.tell("What was not saved is here again", "Undo goes back to the file.")

    def understand_again(self) -> None:
        """Have the same text understood anew, since a file that it names says something else."""
        self._anew = True
        self._news.set()

    def tell(self, title: str, body: str = "", *, wrong: bool = False) -> None:
        """Tell everybody something, in a corner of the page."""
        for client in self.server.get_clients().values():
            color = (200, 40, 40) if wrong else (40, 110, 70)
            client.add_notification(title, body, color=color, auto_close_seconds=8.0)

    def attempt(self, work: Callable[[], Any]) -> None:
        """Do what somebody asked for; what is wrong is told, and nothing ends."""
        try:
            work()
        except (KinolabError, OSError) as error:
            self.tell("That does not work", str(error), wrong=True)
        except Exception as error:
            print(traceback.format_exc(), file=sys.stderr)
            self.tell("This is a mistake in kinolab", f"{error}. Please report it.", wrong=True)

    def _changed(self) -> None:
        self.folder.autosave(self.path, self.text)
        self._news.set()

    def _understand(self) -> None:
        """Find what the text means whenever it changes; texts that were replaced are left out."""
        while not self._over:
            self._news.wait()
            self._news.clear()
            if not self._over:
                self.attempt(self._understand_now)

    def _understand_now(self) -> None:
        text = self.text.text
        if text != self.meaning.text or self._anew:
            self._anew = False
            meaning = meaning_of(text, self.path, self.meaning)
            if self.text.text != text:
                self._news.set()
                self.meaning = meaning if not meaning.stale else self.meaning
                return  # panels would show what is over
            self.meaning = meaning
            if meaning.problem is not None and not meaning.stale:
                with self.server.atomic():
                    self.scene.show(meaning.problem, touching=meaning.touching)
        for listener in self._listeners:
            self.attempt(partial(listener, self.meaning))
