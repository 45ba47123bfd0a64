"""``plan check``: verify finished runs from their files alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import FAILED, PATH, json_option, quiet_option
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say
from kinolab.errors import InputError, Mistake

if TYPE_CHECKING:
    from kinolab.verification import Certificate


@click.command("check")
@click.argument("folders", nargs=-1, required=True, type=PATH)
@click.option(
    "--thorough",
    is_flag=True,
    help="Compare the equations of motion with a second derivation along the whole motion.",
)
@json_option
@quiet_option
def command(folders: Sequence[Path], thorough: bool, as_json: bool, quiet: bool) -> int:
    """Verify finished runs from their files alone."""
    from kinolab.runs import check_run, check_to_json, margin_to_json

    progress = Progress(quiet)

    def checked(folder: Path) -> Certificate:
        told = partial(progress, passing=True)
        return check_run(folder, lambda text: told(f"{folder}: {text}"), thorough=thorough)

    certificates: dict[str, Certificate] = {}
    mistakes: list[Mistake] = []  # in folders that cannot be checked; others are, all the same
    for folder in folders:
        try:
            certificates[str(folder)] = checked(folder)
        except InputError as error:
            mistakes += (_in_folder(folder, mistake) for mistake in error.mistakes)
    progress.close()
    if mistakes and not certificates:
        raise InputError(mistakes)
    if as_json:
        runs = [
            {
                "folder": folder,
                "passed": certificate.passed,
                "checks": [check_to_json(check) for check in certificate.checks],
                "margin": margin_to_json(certificate),
                "conditions": asdict(certificate.conditions) if certificate.conditions else None,
            }
            for folder, certificate in certificates.items()
        ]
        echo_json({"runs": runs})
    else:
        for name, certificate in certificates.items():
            say(escaped(f"{name}: {'passed' if certificate.passed else 'FAILED'}"))
            for told in (*certificate.checks, *filter(None, [certificate.margin])):
                say(f"  {escaped(str(told))}")
            for line in str(certificate.conditions or "").splitlines():
                say(f"  {escaped(line)}")
    if mistakes:
        raise InputError(mistakes)
    return 0 if all(certificate.passed for certificate in certificates.values()) else FAILED


def _in_folder(folder: Path, mistake: Mistake) -> Mistake:
    """Return a mistake in one of a run's files with the run's folder."""
    place = Path(mistake.where)
    if folder in (place, *place.parents):
        return mistake
    return replace(mistake, where=f"{folder}: {mistake.where}" if mistake.where else str(folder))
