"""Exercises of chapter 05."""

from __future__ import annotations

from kinolab.testing.judging import Exercise

EXERCISES: tuple[Exercise, ...] = ()
