"""Machines (``.txt``) and scenarios to start from; ``{name}`` is the machine's."""
