"""KPIECE: a tree that grows from important cells."""
