"""Exercises of chapter 02."""

from __future__ import annotations

from kinolab.testing.judging import Exercise

EXERCISES: tuple[Exercise, ...] = ()
