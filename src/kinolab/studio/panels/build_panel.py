"""Build: obstacles are added, moved, turned, sized, named and coloured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.scenario.values import rgb_of
from kinolab.studio.core import edits
from kinolab.studio.core.meaning import ScenarioMeaning
from kinolab.studio.scene.gizmo import Gizmo, rpy_of, size_in, snapped
from kinolab.studio.scene.page_inputs import on_hand, on_press, show
from kinolab.studio.scene.scene_nodes import wxyz_of
from kinolab.studio.scene.session import Session
from kinolab.world.obstacles.obstacle import rotation

KINDS = {"Box": "box", "Ball": "sphere", "Cylinder": "cylinder", "Capsule": "capsule"}
SCALED = ("mesh", "cloud")  # kinds whose size is a factor
SIZES = {  # what the three numbers of a size are
    "box": "Edges along x, y and z [m]",
    "sphere": "Radius [m] (the first number)",
    "cylinder": "Radius and length [m] (the first two)",
    "capsule": "Radius, and length between the round ends [m] (the first two)",
    **dict.fromkeys(SCALED, "Scale along x, y and z"),
    "map": "Height of walls [m] (the last number)",
}
NONE = "(none)"
SNAPS = {"off": 0.0, "0.05 m": 0.05, "0.1 m": 0.1, "0.25 m": 0.25, "0.5 m": 0.5}
LEAST = 0.01  # [m] of an edge that is drawn with the mouse
WALL_HEIGHT = 0.5  # [m]


class BuildPanel:
    """The tab in which a world is built."""

    def __init__(self, session: Session) -> None:
        gui, self._session = session.server.gui, session
        self._entries: list[dict[str, Any]] = []
        kinds = gui.add_button_group("Add", (*KINDS, "Room"))
        kinds.on_click(lambda event: session.attempt(lambda: self._add(event.target.value)))
        self._wall = on_press(
            session,
            gui.add_button("Wall by two clicks", hint="Then click two points of the ground."),
            self._begin_wall,
        )
        self._snap = gui.add_dropdown("Snap", tuple(SNAPS), initial_value="0.1 m")
        with gui.add_folder("Mesh", expand_by_default=False):
            self._mesh = gui.add_dropdown("File", (NONE,))
            on_press(session, gui.add_button("Add this mesh"), self._add_mesh)
            upload = gui.add_upload_button("Send a mesh file")
            upload.on_upload(lambda event: session.attempt(lambda: self._sent(event.target.value)))
        with gui.add_folder("Chosen obstacle"):
            self._which = on_hand(session, gui.add_dropdown("Which", (NONE,)), self._choose)
            self._own = gui.add_folder(None, visible=False)
        with self._own:
            self._name = on_hand(
                session, gui.add_text("Name", ""), lambda v: self._alter("name", name=v)
            )
            self._place = self._vector("Position [m]", lambda v: {"position": edits.tidy(v)})
            self._turn = self._vector(
                "Roll, pitch, yaw [deg]", lambda v: {"rpy": edits.tidy(map(math.radians, v))}
            )
            self._size = self._vector("Size [m]", self._sized)
            self._words = gui.add_markdown("")
            self._color = on_hand(session, gui.add_rgb("Colour", (185, 198, 214)), self._paint)
            both = gui.add_button_group("", ("Duplicate", "Delete"))
            both.on_click(lambda event: session.attempt(lambda: self._do(event.target.value)))
        self._gizmo = Gizmo(session, "/gizmo/move", self._moved)
        self._corner = Gizmo(session, "/gizmo/size", self._stretched, disable_rotations=True)
        self._first: Array | None = None
        self._walling = False
        session.server.scene.on_click()(self._clicked)
        session.on_choice(lambda _: self._show())
        session.listen(self._listen)

    @property
    def _number(self) -> int | None:
        number = self._session.chosen
        return number if number is not None and number < len(self._entries) else None

    def _vector(self, label: str, keys: Any) -> Any:
        handle = self._session.server.gui.add_vector3(label, (0.0, 0.0, 0.0), step=0.05)
        what = label.partition(" [")[0].lower()
        return on_hand(self._session, handle, lambda v: self._alter(what, **keys(v)))

    def _listen(self, _: ScenarioMeaning) -> None:
        self._entries = edits.obstacles(self._session.text.values)
        files = (NONE, *self._session.folder.meshes())
        if self._mesh.options != files:
            self._mesh.options = files
        self._show()

    def _labels(self) -> list[str]:
        return [
            f"{k + 1}: {e.get('name') or edits.kind_of(e)}" for k, e in enumerate(self._entries)
        ]

    def _show(self) -> None:
        """Show the chosen obstacle in all inputs, and the gizmos at it."""
        labels, number = self._labels(), self._number
        options = (NONE, *labels)
        if self._which.options != options:
            self._which.options = options
        show(self._which, NONE if number is None else labels[number])
        self._own.visible = number is not None
        if number is None:
            self._gizmo.hide()
            self._corner.hide()
            return
        entry, kind = self._entries[number], edits.kind_of(self._entries[number])
        place, rpy = _place(entry)
        show(self._name, str(entry.get("name", "")))
        show(self._place, tuple(place))
        show(self._turn, tuple(math.degrees(angle) for angle in rpy))
        size = _size(entry)
        show(self._size, tuple(size))
        self._words.content = SIZES.get(kind, "")
        color = entry.get("color")
        color = color[0] if isinstance(color, list) and color else color
        if isinstance(color, str) and len(color) == 7:
            show(self._color, tuple(round(255 * part) for part in rgb_of(color)))
        turn = np.asarray(rotation(rpy))
        wxyz = _wxyz(rpy)
        self._gizmo.show(place, wxyz, size=size_in(self._session, max(_edges(entry))))
        if kind in KINDS.values():
            corner = np.array(place) + turn @ (0.5 * np.array(_edges(entry)))
            self._corner.show(corner, wxyz, size=0.5 * size_in(self._session, 0.0))
        else:
            self._corner.hide()

    def _choose(self, label: str) -> None:
        labels = self._labels()
        self._session.choose(labels.index(label) if label in labels else None)

    def _alter(self, what: str, *, going_on: bool = True, **keys: Any) -> None:
        number = self._number
        if number is not None:
            changes = edits.alter(self._session.text.values, number, **keys)
            self._session.edit(f"change the {what}", changes, going_on=going_on)

    def _sized(self, size: Any) -> dict[str, Any]:
        number = self._number
        assert number is not None
        return _with_size(self._entries[number], [max(float(v), LEAST) for v in size])

    def _paint(self, color: tuple[int, int, int]) -> None:
        self._alter("colour", color="#{:02x}{:02x}{:02x}".format(*color))

    def _do(self, what: str) -> None:
        number, values = self._number, self._session.text.values
        if number is None:
            return
        if what == "Duplicate":
            shift = max(_edges(self._entries[number])) + 0.2
            self._session.edit("duplicate", edits.duplicate(values, number, shift))
            self._take_last()
        else:
            self._session.choose(None)
            self._session.edit("delete", edits.remove(values, number))

    def _add(self, what: str) -> None:
        values = self._session.text.values
        if what == "Room":
            low, high = self._bounds()
            changes = edits.add_room(values, low, high, WALL_HEIGHT)
            self._session.edit("add a room", changes)
            return
        kind = KINDS[what]
        size = edits.NEW_SIZES[kind]
        x, y = self._free_place()
        z = 0.25  # [m] of the middle of a new obstacle: it stands on the ground
        changes = edits.add_obstacle(values, kind, size, [x, y, z])
        self._session.edit(f"add a {what.lower()}", changes)
        self._take_last()

    def _add_mesh(self) -> None:
        if self._mesh.value != NONE:
            stem = self._mesh.value.rpartition("/")[2].rpartition(".")[0]
            place = [0.0, 0.0, 0.0]
            values = self._session.text.values
            changes = edits.add_obstacle(values, "mesh", self._mesh.value, place, stem)
            self._session.edit("add a mesh", changes)
            self._take_last()

    def _sent(self, file: Any) -> None:
        name = self._session.folder.keep_mesh(file.name, file.content)
        self._mesh.options = (NONE, *self._session.folder.meshes())
        self._mesh.value = name
        self._add_mesh()

    def _take_last(self) -> None:
        self._entries = edits.obstacles(self._session.text.values)
        self._session.choose(len(self._entries) - 1)

    def _bounds(self) -> tuple[list[float], list[float]]:
        """Return two corners of the ground."""
        bounds = self._session.text.values.get("world", {}).get("bounds", {})
        x, y = (bounds.get(axis, (-5.0, 5.0)) for axis in "xy")
        return [float(x[0]), float(y[0])], [float(x[1]), float(y[1])]

    def _free_place(self) -> tuple[float, float]:
        """Return a place in the middle of the world, beside what is there."""
        low, high = self._bounds()
        middle = 0.5 * (np.array(low) + high)
        taken = np.array([_place(entry)[0][:2] for entry in self._entries]).reshape(-1, 2)
        for ring in range(20):
            for angle in np.linspace(0.0, 2.0 * np.pi, max(6 * ring, 1), endpoint=False):
                # 0.8 [m] between rings of places that are tried
                place = middle + 0.8 * ring * np.array([np.cos(angle), np.sin(angle)])
                # 0.6 [m] from the middle of another obstacle at which a new one is put
                if not len(taken) or np.abs(taken - place).max(axis=1).min() > 0.6:
                    return float(place[0]), float(place[1])
        return float(middle[0]), float(middle[1])

    def _moved(self, place: Array, wxyz: Array, over: bool) -> None:
        number, snap = self._number, SNAPS[self._snap.value]
        if number is None:
            return
        place = snapped(place, snap)
        self._session.scene.move_obstacle(number, place, wxyz)
        if over:
            before, rpy = _place(self._entries[number])
            # 1e-6 of the product of two attitudes, from 1: the gizmo was only moved
            turned = np.abs(np.abs(_wxyz(rpy) @ wxyz) - 1.0) > 1e-6
            turn = edits.tidy(rpy_of(wxyz, snap=bool(snap)) if turned else rpy)
            moved = np.abs(place - before).max() > 0.5 * snap if snap else True
            keys = {"position": edits.tidy(place)} if moved and not turned else {}
            self._alter("place", going_on=False, **keys, **({"rpy": turn} if turned else {}))
            self._show()

    def _stretched(self, place: Array, _: Array, over: bool) -> None:
        number, snap = self._number, SNAPS[self._snap.value]
        if number is None or not over:
            return
        entry = self._entries[number]
        middle, rpy = _place(entry)
        half = np.abs(rotation(rpy).T @ (place - middle))
        edges = np.maximum(snapped(2.0 * half, snap), max(snap, LEAST))
        if edits.kind_of(entry) != "box":
            before = 0.5 * np.array(_edges(entry))
            k = int(np.argmax(np.abs(half - before)[:2]))  # the side that was dragged
            caps = edges[k] if edits.kind_of(entry) == "capsule" else 0.0
            edges = np.array([0.5 * edges[k], max(edges[2] - caps, LEAST), 0.0])
        self._alter("size", going_on=False, **_with_size(entry, edges.tolist()))
        self._show()

    def _begin_wall(self) -> None:
        self._walling, self._first = not self._walling, None
        self._wall.label = (
            "Click two points (or here to stop)" if self._walling else ("Wall by two clicks")
        )

    def _clicked(self, event: Any) -> None:
        """Take a point of the ground for a wall."""
        if not self._walling:
            return
        origin, along = np.array(event.ray_origin), np.array(event.ray_direction)
        if along[2] == 0.0 or -origin[2] / along[2] <= 0.0:  # to the sky
            return
        point = snapped(origin - origin[2] / along[2] * along, SNAPS[self._snap.value])
        if self._first is None:
            self._first = point
            return
        first, self._first = self._first, None
        self._begin_wall()

        def add() -> None:
            values = self._session.text.values
            changes = edits.add_wall(values, first.tolist(), point.tolist(), WALL_HEIGHT)
            self._session.edit("add a wall", changes)
            self._take_last()

        self._session.attempt(add)


def _place(entry: dict[str, Any]) -> tuple[list[float], list[float]]:
    """Return position and roll, pitch and yaw; zeros where something else is written."""
    return _three(entry.get("position")), _three(entry.get("rpy"))


def _three(value: Any) -> list[float]:
    good = (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(v, int | float) for v in value)
    )
    return [float(v) for v in value] if good else [0.0] * 3


def _size(entry: dict[str, Any]) -> list[float]:
    """Return the three numbers that the panel shows as an obstacle's size."""
    kind = edits.kind_of(entry)
    if kind == "map":
        return _three([0.0, 0.0, entry.get("height", 1.0)])
    scaled = kind in SCALED
    value = entry.get("scale", 1.0) if scaled else entry.get(kind)
    if isinstance(value, int | float):
        return [float(value), *([float(value)] * 2 if scaled else [0.0, 0.0])]
    return _three([*value, 0.0][:3] if isinstance(value, list) else None)


def _with_size(entry: dict[str, Any], size: list[float]) -> dict[str, Any]:
    """Return the key that says a size, with its value."""
    kind, numbers = edits.kind_of(entry), edits.tidy(size)
    if kind == "sphere":
        return {kind: numbers[0]}
    if kind in ("cylinder", "capsule"):
        return {kind: numbers[:2]}
    if kind == "map":
        return {"height": numbers[2]}
    return {"scale" if kind in SCALED else kind: numbers}


def _edges(entry: dict[str, Any]) -> list[float]:
    """Return the edges of the box around an obstacle before it is turned, in [m]."""
    kind, size = edits.kind_of(entry), _size(entry)
    if kind == "sphere":
        return [2.0 * size[0]] * 3
    if kind == "capsule":
        return [2.0 * size[0], 2.0 * size[0], size[1] + 2.0 * size[0]]
    return [2.0 * size[0], 2.0 * size[0], size[1]] if kind == "cylinder" else size


def _wxyz(rpy: list[float]) -> Array:
    return wxyz_of(rotation(rpy))
