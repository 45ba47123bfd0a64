"""Machines (``.txt``) and scenarios that ``plan new`` writes; ``{name}`` is the machine's."""
