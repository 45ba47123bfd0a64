"""Look: from where the scene is seen, and how."""

from __future__ import annotations

import threading
import time
from typing import Any, get_args

import numpy as np

from kinolab.show.scene.camera import View
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.scene.page_inputs import on_hand
from kinolab.studio.scene.session import Session

VIEWS: dict[str, View] = {
    "All": "perspective", "Top": "top", "Front": "front", "Side": "side",
}  # fmt: skip


class LookPanel:
    """The tab with the views."""

    def __init__(self, session: Session) -> None:
        assert set(VIEWS.values()) == set(get_args(View))
        self._session, gui = session, session.server.gui
        views = gui.add_button_group("View", tuple(VIEWS))
        views.on_click(lambda e: session.attempt(lambda: self._look(e.client, e.target.value)))
        self._follow = on_hand(
            session, gui.add_checkbox("Follow the machine", False), self._follows
        )
        on_hand(session, gui.add_checkbox("Labels", True), self._label)
        on_hand(session, gui.add_checkbox("Dark", False), self.theme)
        self._scale = gui.add_markdown("")
        self._seen: Any = None
        self._follower: threading.Thread | None = None
        self._over = False
        session.listen(self._listen)
        session.server.on_client_connect(self._arrived)

    def close(self) -> None:
        """Follow nothing any more."""
        self._over = True
        if self._follower is not None:
            self._follower.join()

    def theme(self, dark: bool) -> None:
        """Show the page dark or light."""
        self._session.server.gui.configure_theme(
            dark_mode=dark, show_logo=False, show_share_button=False, control_width="large"
        )

    def _listen(self, meaning: ScenarioMeaning) -> None:
        if meaning.problem is None or meaning.stale:
            return
        size = self._session.scene.size
        step = self._session.scene.spacing
        lines = f"; lines on the floor are {step:g} m apart" if step else ""
        self._scale.content = f"What is seen is {size:.3g} m wide{lines}."
        seen = (self._session.path, meaning.problem.machine.name)
        if seen != self._seen:
            self._seen = seen
            self._look_all()

    def _arrived(self, client: Any) -> None:
        """Show all of it to a tab that opens, and again once its panels have their place."""
        if self._seen is not None:
            self._look(client, "All")
            self.refit()

    def refit(self) -> None:
        """Show all of it to every tab, once its panels have their place."""
        # 1.5 [s] after which a page has its layout
        again = threading.Timer(1.5, self._session.attempt, [self._look_all])
        again.daemon = True
        again.start()

    def _look_all(self) -> None:
        for client in self._session.server.get_clients().values():
            self._look(client, "All")

    def _look(self, client: Any, name: str) -> None:
        if client is None or self._seen is None:
            return
        camera, width, height = client.camera, client.camera.image_width, client.camera.image_height
        seen = self._session.scene.camera(VIEWS[name], (max(width, 1), max(height, 1)))
        with client.atomic():
            camera.fov, camera.up_direction = seen.fov, seen.axes[1] if name == "Top" else seen.up
            camera.position, camera.look_at = seen.position, seen.target

    def _label(self, on: bool) -> None:
        scene = self._session.scene
        scene.labels = on
        if scene.problem is not None:
            scene.show(scene.problem, touching=self._session.meaning.touching)

    def _follows(self, on: bool) -> None:
        if on:
            self._follower = threading.Thread(target=self._run, daemon=True)
            self._follower.start()

    def _run(self) -> None:
        """Move all cameras with the machine, until nobody wants it any more."""
        before = self._session.scene.place
        while self._follow.value and not self._over:
            time.sleep(1.0 / 20.0)  # [s] between two looks after a machine that is followed
            now = self._session.scene.place
            if np.abs(now - before).max() > 0.0:
                for client in self._session.server.get_clients().values():
                    client.camera.look_at = client.camera.look_at + now - before
                    client.camera.position = client.camera.position + now - before
            before = now
