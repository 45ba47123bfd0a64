"""From a machine's description to its equations of motion."""
