"""Templates of URDF files: xacro, where it is installed, writes the file that is read."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

from kinolab.errors import InputError, Mistake

COMMENTS = re.compile(rb"<!--.*?-->", re.DOTALL)
INSTALL = "pip install xacro, or run xacro on it first: xacro robot.xacro > robot.urdf"


def expanded(path: Path, content: bytes) -> bytes:
    """Return a file's content, or what xacro makes of it if it is a template.

    Arguments have the values that the template itself gives them. Expressions in a template are
    code of Python that xacro evaluates.

    Raises:
        InputError: If it is a template and xacro is not installed, or fails.
    """
    if not re.search(rb"<xacro:|\$\{", COMMENTS.sub(b"", content)):
        return content
    try:
        xacro = import_module("xacro")
    except ImportError as error:
        what = "it is a xacro template, not a URDF."
        raise InputError([Mistake(path.name, what, INSTALL)]) from error
    try:
        return bytes(xacro.process_file(str(path)).toxml("utf-8"))
    except Exception as error:  # of xacro, of expressions, and of packages that are not found
        what = f"xacro cannot expand it ({str(error).strip() or type(error).__name__})."
        raise InputError([Mistake(path.name, what, "Run xacro on it to see where.")]) from error
