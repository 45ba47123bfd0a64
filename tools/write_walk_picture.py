"""Write docs/images/walk.png: the machine of docs/walk.md in one pose, with its frames.

    python tools/write_walk_picture.py [--check]

The machine is the one that the page's own code describes. With --check nothing is written, and it
returns 1 if the picture would change.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import kinolab
from kinolab.show.film.film import staged
from kinolab.show.film.staging.script_writing import write_script
from kinolab.show.scene.problem_picture import picture

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURE = DOCS / "walk.md", DOCS / "images" / "walk.png"
MACHINE = "ball_beam"  # what the page calls it
POSE = {"alpha": -0.2, "r": 0.3, "phi": 0.6}  # all frames are apart
RENDER = {"axes": True, "azimuth": 0.35, "elevation": 0.2, "size": [900, 560]}


def machine() -> Any:
    """Return the machine that the page's code makes, running no more of it than that needs."""
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        if MACHINE not in names:
            exec(code.replace("print(", "str("), names)  # what it prints is on the page
    return names[MACHINE]


def drawn() -> bytes:
    """Return the picture as PNG."""
    table = {
        "title": "A pose",
        "system": machine(),
        "start": POSE,
        "goal": {"r": 0.0},
        "render": RENDER,
    }
    problem = kinolab.load(table | {"world": {"ground": "plane"}})
    x = problem.start[None]
    shown = picture(problem, x)
    shown = replace(shown, start=None, goal=None, path=None)
    script = write_script(shown, [0.0], problem.model.frames(x), size=problem.scenario.render.size)
    out = io.BytesIO()
    assert script.frames is not None
    image = next(staged(script).stage.shots(script.poses[:1], None, script.frames[:1]))
    Image.fromarray(np.ascontiguousarray(image)).save(out, "PNG", optimize=True)
    return out.getvalue()


def main() -> int:
    """Write the picture, or compare it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    made = drawn()
    if parser.parse_args().check:
        return int(not PICTURE.is_file() or PICTURE.read_bytes() != made)
    PICTURE.write_bytes(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
