"""What formulas of machines are made of: symbols, exact expressions, words; and slips of a pen."""
