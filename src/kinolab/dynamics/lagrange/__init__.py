"""The equations of motion a second time, as on paper, by SymPy."""
