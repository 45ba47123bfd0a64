"""Kinds of faults for ``benchmarks/faults.py``, and how their outcomes are judged from outside."""

from . import clocks, crashes, crowds, damaged_caches, hostile_files, kills, storage, streams

KINDS = (
    *damaged_caches.KINDS,
    *kills.KINDS,
    *storage.KINDS,
    *streams.KINDS,
    *crowds.KINDS,
    *clocks.KINDS,
    *crashes.KINDS,
    *hostile_files.KINDS,
)
