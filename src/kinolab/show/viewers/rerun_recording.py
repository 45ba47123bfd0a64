"""A plan as a recording of Rerun."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from kinolab.arguments import checked
from kinolab.files import whole_file
from kinolab.interchange.motion_tables import with_unit
from kinolab.lazy import library_of
from kinolab.problem import PlanningTask
from kinolab.show.scene.content import Content
from kinolab.show.scene.scenes import Shown, content_of_plan
from kinolab.show.viewers.viewed_parts import cables_at, moving_parts, still_parts, times_of

TIMELINE = "motion"
ROOT = "world"


@checked
def show_in_rerun(problem: PlanningTask, plan: Shown, path: str | Path | None = None) -> Any:
    """Show a plan in Rerun: the machine in its world, and states and inputs over time.

    Args:
        plan: The result of planning, a trajectory, or a run that was read.
        path: Of a recording that is written instead, such as ``run.rrd``; left out, Rerun's viewer
            is started.

    Returns:
        The ``rerun.RecordingStream``, to log more into.

    Raises:
        InputError: If an argument does not fit, or Rerun is not installed.
    """
    rerun = library_of("rerun", "rerun", "recordings of Rerun need rerun-sdk")
    content = content_of_plan(problem, plan)
    recording = rerun.RecordingStream("kinolab", recording_id=None)
    if path is None:
        recording.spawn()
        _log(rerun, recording, content)
        return recording
    with whole_file(Path(path)) as file:
        stream = recording.binary_stream()
        _log(rerun, recording, content)
        file.write(stream.read() or b"")
    return recording


def _log(rerun: Any, recording: Any, content: Content) -> None:
    axis = "XYZ"[int(np.argmax(np.abs(content.picture.up)))]
    up = getattr(rerun.ViewCoordinates, f"RIGHT_HAND_{axis}_UP")
    recording.log(ROOT, up, static=True)
    for part in still_parts(content):
        _log_mesh(rerun, recording, [ROOT, "obstacles", part.name], part)
    times = times_of(content)
    index = [rerun.TimeColumn(TIMELINE, duration=times)]
    for part in moving_parts(content):
        name = [ROOT, "machine", part.name]
        _log_mesh(rerun, recording, name, part)
        poses = rerun.Transform3D.columns(translation=part.places, quaternion=part.turns)
        recording.send_columns(rerun.new_entity_path(name), indexes=index, columns=poses)
    cables = cables_at(content)
    for k, t in enumerate(times if cables.size else ()):
        recording.set_time(TIMELINE, duration=float(t))
        recording.log([ROOT, "cables"], rerun.LineStrips3D(list(cables[k])))
    if content.picture.path is not None:
        recording.log([ROOT, "path"], rerun.LineStrips3D([content.picture.path]), static=True)
    for series in content.series:
        knots = content.knots[: len(series.values)]
        index = [rerun.TimeColumn(TIMELINE, duration=knots)]
        columns = zip(series.names, series.units, series.values.T, strict=True)
        for quantity, unit, values in columns:
            recording.send_columns(
                rerun.new_entity_path([series.title, with_unit(quantity, unit)]),
                indexes=index,
                columns=rerun.Scalars.columns(scalars=values),
            )


def _log_mesh(rerun: Any, recording: Any, name: list[str], part: Any) -> None:
    mesh = rerun.Mesh3D(
        vertex_positions=part.vertices,
        triangle_indices=part.triangles,
        vertex_colors=np.rint(255.0 * part.colors).astype(np.uint8),
    )
    recording.log(name, mesh, static=True)
