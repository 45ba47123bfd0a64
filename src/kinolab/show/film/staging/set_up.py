"""From a script to a film: the scene that its frames are drawn in, and the inset."""

from __future__ import annotations

from kinolab.show.film.film import Film
from kinolab.show.film.staging.inset_place import build_inset, whole_window
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.stage import build_scene
from kinolab.show.film.travelling import Travelling


def staged(script: Script) -> Film:
    """Build the scene of a film, which can then be drawn."""
    stage = build_scene(script.picture, script.motion, script.size)
    window = whole_window(stage, script.poses, script.size) if script.picture.follow else None
    if window is not None:
        travelling = Travelling(window, script.size)
        return Film(travelling, script.playback, script.poses, script.lines, script.title)
    inset = build_inset(stage, script.poses, script.size) if script.magnify else None
    return Film(stage, script.playback, script.poses, script.lines, script.title, inset)
