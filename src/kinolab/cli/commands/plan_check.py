"""``plan check``: verify finished runs from their files alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import FAILED, PATH, json_option, quiet_option
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say

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

    certificates = {str(folder): checked(folder) for folder in folders}
    progress.close()
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
        for folder, certificate in certificates.items():
            say(escaped(f"{folder}: {'passed' if certificate.passed else 'FAILED'}"))
            for told in (*certificate.checks, *filter(None, [certificate.margin])):
                say(f"  {escaped(str(told))}")
            for line in str(certificate.conditions or "").splitlines():
                say(f"  {escaped(line)}")
    return 0 if all(certificate.passed for certificate in certificates.values()) else FAILED
