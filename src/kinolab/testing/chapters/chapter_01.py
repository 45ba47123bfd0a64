"""Exercises of chapter 01."""

from __future__ import annotations

from kinolab.testing.judging import Exercise

EXERCISES: tuple[Exercise, ...] = ()
