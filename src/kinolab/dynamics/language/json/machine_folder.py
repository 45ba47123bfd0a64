"""The files that carry a machine as data: a controller's lies beside the machine's."""

from __future__ import annotations

from pathlib import Path

from kinolab.files import read_ordinary
from kinolab.untrusted import BYTES

MACHINE_FILE = "machine.json"
FEEDBACK_FILE = "feedback.json"  # only of a machine that has a controller


def texts_of(path: Path) -> dict[str, str]:
    """Return the texts of a machine's file and of the controller beside it, by the names above.

    Raises:
        OSError: If one of them cannot be read.
        UnicodeDecodeError: If one of them is no text.
    """
    files = {MACHINE_FILE: path, FEEDBACK_FILE: path.with_name(FEEDBACK_FILE)}
    present = {name: file for name, file in files.items() if file is path or file.is_file()}
    return {
        name: read_ordinary(file, BYTES["machine"]).decode("utf-8-sig")
        for name, file in present.items()
    }
