"""The plots in the folder of a run, by their names."""

from __future__ import annotations

FORMS = ("svg", "png")
NAMES = ("states", "inputs", "phase", "configuration")
FILES = tuple(f"{name}.{form}" for form in FORMS for name in NAMES)
