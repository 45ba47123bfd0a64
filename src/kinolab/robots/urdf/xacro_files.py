"""Templates of URDF files: xacro, where it is installed, writes the file that is read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from kinolab.errors import InputError, Mistake
from kinolab.robots.urdf.mesh_files import PACKAGE, find_mesh

COMMENTS = re.compile(rb"<!--.*?-->", re.DOTALL)
INSTALL = "pip install xacro, or run xacro on it first: xacro robot.xacro > robot.urdf"


def expanded(path: Path, content: bytes, packages: Mapping[str, str | Path]) -> bytes:
    """Return a file's content, or what xacro makes of it if it is a template.

    Arguments have the values that the template itself gives them. Expressions in a template are
    code of Python that xacro evaluates.

    Args:
        packages: As ``find_mesh`` takes them, for what ``$(find package)`` names, where ROS does
            not know it.

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
        with _found_beside(xacro, path.parent, packages):
            written = bytes(xacro.process_file(str(path)).toxml("utf-8"))
        return written.replace(f"file://{PACKAGE}".encode(), PACKAGE.encode())
    except InputError as error:
        raise InputError(replace(one, where=path.name) for one in error.mistakes) from error
    except Exception as error:  # of xacro, of expressions, and of packages that are not found
        what = f"xacro cannot expand it ({str(error).strip() or type(error).__name__})."
        raise InputError([Mistake(path.name, what, "Run xacro on it to see where.")]) from error


@contextmanager
def _found_beside(xacro: Any, folder: Path, packages: Mapping[str, str | Path]) -> Iterator[None]:
    """Let xacro look for packages that ROS does not know where their meshes are looked for."""
    finders, placers = vars(import_module("xacro.substitution_args")), vars(xacro)
    known: Callable[[str], str] = finders["_eval_find"]
    placed: Callable[[str], str] = placers["abs_filename_spec"]

    def find(package: str) -> str:
        try:
            return known(package)
        except Exception:  # without ROS, or of its index
            return f"{PACKAGE}{package}"

    def place(name: str) -> str:
        if not name.startswith(PACKAGE):
            return placed(name)
        if (found := find_mesh(name, folder, packages)) is None:
            what = f"what it includes is not in the folders above it: {name}."
            remedy = "Keep the folders of packages beside each other."
            raise InputError([Mistake("", what, remedy)])
        return str(found)

    finders["_eval_find"], placers["abs_filename_spec"] = find, place
    try:
        yield
    finally:
        finders["_eval_find"], placers["abs_filename_spec"] = known, placed
