"""The content of a page: small values in JSON, of a report what fits; arrays in a pack."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kinolab.numerics.arrays import Array, finite_or_none
from kinolab.show.page.follow import follow_track
from kinolab.show.page.pack import Pack, Place
from kinolab.show.scene.captions import captions
from kinolab.show.scene.content import Content, Curve, Keys, Series
from kinolab.show.scene.frame_axes import axis_length
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.ground import grid_step, marked_areas, marked_lines
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, by_color, is_room, join
from kinolab.show.scene.picture import Floor, Ghost, GoalMarker, Picture
from kinolab.show.scene.problem_picture import WORLD
from kinolab.show.scene.still import GOAL, START, Extent, Still, extent

TEXTS = ("status", "message", "planner")
NUMBERS = ("seed", "iterations", "cost", "duration", "goal_distance")
LARGEST = sys.float_info.max  # JSON has larger ones


def page_data(content: Content) -> tuple[dict[str, Any], str]:
    """Return the data of a page: an object for JSON, and the text of its pack."""
    pack, picture, keys = Pack(), content.picture, content.keys
    seen, driving = extent(content), content.driving
    still, angles = seen.still, seen.still.outlook.angles
    data = {
        "format": 1,  # version of the data; the page's modules always match it
        "title": content.title,
        "name": content.name,
        "machine": content.machine,
        "up": (np.asarray(picture.up) / np.linalg.norm(picture.up)).tolist(),
        "view": "follow" if picture.follow else picture.view,
        "speed": content.speed,
        "azimuth": angles.azimuth,
        "elevation": angles.elevation,
        "follow": pack.add(_follow(content, seen), "f4"),
        "setting": _setting(picture),
        "captions": [{"text": each.text, "place": list(each.place)} for each in captions(still)],
        "hull": pack.add(seen.hull, "f4"),
        "floor": _floor(still.floor, picture, pack),
        "leading": content.leading,
        "frames": {
            "names": [WORLD, *content.joints, *(body.name for body in picture.bodies)],
            "length": axis_length(still.reach, still.size, _frames(content)),
            "shown": picture.frames is not None,
            "joints": _moving(keys.joints or Keys((), ()), pack),
        },
        "bodies": [
            {"name": body.name, "whirl": body.whirl, "mesh": mesh_data(mesh, pack)}
            for body, mesh in zip(picture.bodies, still.machine, strict=True)
        ],
        "motion": _moving(keys, pack),
        "radii": picture.radii.tolist(),
        "obstacles": _obstacles(still, pack),
        "cones": [
            {"forbidden": cone.forbidden, "mesh": mesh_data(cone_mesh(cone), pack)}
            for cone in picture.cones
        ],
        "start": _mark(picture.start, START, picture.radii),
        "goal": _mark(picture.goal, GOAL, picture.radii),
        "points": [_mark(point, GOAL, picture.radii) for point in picture.points],
        "tree": None if content.tree is None else pack.add(content.tree, "f4"),
        "knots": pack.add(content.knots, "f8"),
        "series": [_series(series, pack) for series in content.series],
        "constraints": list(content.constraints),
        # For ``drive.js``; the machine's code is among the scripts.
        "driving": driving and {**driving.facts, "states": pack.add(driving.states, "f8")},
        "posing": content.posing,
        "facts": facts_told(content.facts),
        "live": content.live,
    }
    return data, pack.text()


def _frames(content: Content) -> int:
    return 1 + len(content.joints) + len(content.picture.bodies)


def _moving(keys: Keys, pack: Pack) -> dict[str, Any]:
    return {
        "places": [_curve(curve, pack) for curve in keys.places],
        "turns": [_curve(curve, pack) for curve in keys.turns],
        "ends": None if keys.ends is None else _curve(keys.ends, pack),
    }


def _curve(curve: Curve, pack: Pack) -> dict[str, Place]:
    return {
        "times": pack.add(curve.times, "f8"),
        "values": pack.add(curve.values, "f4"),
        "arriving": pack.add(curve.arriving, "f4"),
        "leaving": pack.add(curve.leaving, "f4"),
    }


def _obstacles(still: Still, pack: Pack) -> list[dict[str, Any]]:
    """The obstacles; what hides the way is an entry of its own, which is translucent."""
    names = [obstacle.name for obstacle in still.picture.obstacles]
    found = []
    for name, mesh, veiled in zip(names, still.obstacles, still.outlook.veiled, strict=True):
        room = is_room(mesh)
        parts = [(mesh, False)]
        if veiled.any():
            parts = [(mesh.only(~veiled), False), (mesh.only(veiled), True)]
        found += [
            {"name": name, "room": room, "veiled": veil, "mesh": mesh_data(part, pack)}
            for part, veil in parts
        ]
    return found


def _follow(content: Content, seen: Extent) -> Array:
    """Where the camera is that goes with the machine: rows of time, azimuth, elevation."""
    times = content.keys.places[0].times
    rows = np.linspace(0, len(times) - 1, len(seen.motion)).astype(int)
    return follow_track(
        content.picture, seen.still.obstacles, times[rows], seen.motion, seen.still.reach
    )


def _setting(picture: Picture) -> dict[str, Any]:
    """Colours of sky and ground; the studio's are those of the page's theme."""
    colors = picture.colors
    return {
        "name": picture.setting,
        "sky": [list(color) for color in colors.sky],
        "floor": list(colors.floor),
        "lines": list(colors.lines),
        "dark": colors.is_dark,
    }


def _floor(floor: Floor | None, picture: Picture, pack: Pack) -> dict[str, Any] | None:
    """The ground between two corners, with the lines and areas that are painted on it."""
    if floor is None:
        return None
    low, high = floor.low, floor.high
    areas = list(marked_areas(low, high, picture.colors))
    return {
        "low": low.tolist(),
        "high": high.tolist(),
        "step": grid_step(float(np.max(high - low))),
        "lines": pack.add(marked_lines(low, high, picture.colors).reshape(-1), "f4"),
        "areas": mesh_data(join(areas), pack) if areas else None,
    }


def _mark(
    mark: GoalMarker | Ghost | None, color: tuple[float, float, float], radii: Array
) -> dict[str, Any] | None:
    """Return a region in a colour, or the machine at poses with its cables."""
    if mark is None:
        return None
    if isinstance(mark, GoalMarker):
        return {"position": list(mark.position), "radius": mark.radius, "rgb": list(color)}
    cables = [
        {"ends": ends.ravel().tolist(), "radius": float(radius)}
        for ends, radius in zip(mark.lines, radii, strict=True)
        if np.isfinite(ends).all()
    ]
    return {"poses": mark.table.tolist(), "cables": cables, "rgb": list(color)}


def _series(series: Series, pack: Pack) -> dict[str, Any]:
    return {
        "title": series.title,
        "names": list(series.names),
        "units": list(series.units),
        "held": series.held,
        "limits": [
            [finite_or_none(low), finite_or_none(high), whose] for low, high, whose in series.limits
        ],
        "first": series.first,
        "values": pack.add(series.values.T, "f4"),
    }


def facts_told(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of a report that a page tells, each of the kind that its scripts expect.

    Numbers that are not finite are None, as JSON requires; what is of another kind is left out.
    """
    kept = {key: report[key] for key in TEXTS if isinstance(report.get(key), str)}
    kept |= {key: _number(report[key]) for key in NUMBERS if key in report}
    parts, margin, checks = (
        report.get(key) for key in ("goal_distance_by_unit", "margin", "verification")
    )
    if isinstance(parts, Mapping):
        kept["goal_distance_by_unit"] = {str(unit): _number(part) for unit, part in parts.items()}
    if isinstance(margin, Mapping):
        kept["margin"] = _margin(margin)
    found = [check for check in _listed(checks) if isinstance(check, Mapping)]
    said = [*_listed(report.get("notes")), *_listed(report.get("warnings"))]
    told = [sentence for sentence in said if isinstance(sentence, str)]
    return kept | {"verification": [_check(check) for check in found], "warnings": told}


def _margin(margin: Mapping[str, Any]) -> dict[str, Any]:
    numbers = {key: _number(margin.get(key)) for key in ("clearance", "required", "time")}
    return {**numbers, "beside": [str(name) for name in _listed(margin.get("beside"))]}


def _check(check: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": str(check.get("name", "")),
        "value": _number(check.get("value")),
        "limit": _number(check.get("limit")),
        "passed": check.get("passed") is True,
        "detail": str(check.get("detail") or ""),
    }


def _number(value: object) -> int | float | None:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST:
        return value
    return None


def _listed(value: object) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()


def mesh_data(mesh: SurfaceMesh, pack: Pack) -> dict[str, Any]:
    """Return a mesh as the page's ``meshes.js`` reads it."""
    faces, groups = by_color(mesh)
    return {
        "vertices": pack.add(mesh.vertices, "f4"),
        "faces": pack.indices(faces),
        "edges": pack.indices(mesh.ends[mesh.creases]),
        "colors": [{"rgb": rgb, "first": first, "count": count} for rgb, first, count in groups],
    }
