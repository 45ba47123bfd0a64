"""From equations of motion to machine code."""
