"""JSON serialization of machines: plain data, no code is executed."""
