"""Machines and scenarios that ``plan new`` writes, to start from; ``{name}`` is the machine's."""
