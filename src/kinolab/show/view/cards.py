"""Gallery cards of finished runs, verified and rendered anew from their files."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from kinolab.errors import KinolabError
from kinolab.files import read_ordinary
from kinolab.runs import Run, check_run, margin_to_json, read_run
from kinolab.show.film.film import staged
from kinolab.show.film.staging.script_writing import write_script
from kinolab.show.page import page_html
from kinolab.show.page.gallery import Card, gallery_html
from kinolab.show.scene.problem_picture import picture
from kinolab.show.scene.scenes import content_of


def gallery_of(
    folders: Sequence[Path], title: str, told: Callable[[Path], None] = lambda _: None
) -> tuple[str, list[Card]]:
    """Return a gallery page of runs, and its cards.

    Stored pages and verdicts are not trusted: both are made anew from the machine, the scenario and
    the trajectory.

    Args:
        told: Called with each folder before it is read.
    """
    cards = []
    for folder in folders:
        told(folder)
        cards.append(_card(folder))
    return gallery_html(title, cards), cards


def _card(folder: Path) -> Card:
    try:
        run, certificate = read_run(folder), check_run(folder)
        facts = {**run.report, "verification": [vars(check) for check in certificate.checks]}
        facts["margin"] = margin_to_json(certificate)
        facts["status"] = "solved" if certificate.passed else "verification_failed"
        page = page_html(content_of(run.problem, run.trajectory, facts, run.graph))
        poster = _film(folder) or _poster(run)
    except (KinolabError, OSError) as error:
        return Card(str(folder), str(error), "damaged")
    verdict = "passed" if certificate.passed else "failed"
    title = run.problem.scenario.title
    return Card(str(folder), title, verdict, _facts(run), poster, page)  # type: ignore[arg-type]


def _facts(run: Run) -> tuple[tuple[str, str], ...]:
    report: dict[str, Any] = run.report
    return (
        ("Machine", str(report.get("system", ""))),
        ("Planner", f"{report.get('planner', '')}, seed {report.get('seed', '')}"),
        ("Motion", f"{run.trajectory.duration:.2f} s"),
    )


def _film(folder: Path) -> bytes:
    """Return the run's animation if it is a GIF in its folder, and not too large."""
    path = folder / "animation.gif"
    if path.is_symlink():  # to a picture that is not theirs to show
        return b""
    try:
        content = bytes(read_ordinary(path, 2_000_000))  # largest animation that is embedded
    except OSError:
        return b""
    return content if content.startswith(b"GIF8") else b""


def _poster(run: Run) -> bytes:
    """Render the machine in the middle of its motion, as PNG."""
    problem, trajectory = run.problem, run.trajectory
    shown, poses = picture(problem, trajectory.x), problem.model.frames(trajectory.x)
    film = staged(write_script(shown, trajectory.t, poses, size=(480, 360)))  # pixels
    out = io.BytesIO()
    # 0.5 of the motion, shown on a poster
    image = np.ascontiguousarray(film.frame(int(0.5 * (len(film) - 1))))
    Image.fromarray(image).save(out, "PNG")
    return out.getvalue()
