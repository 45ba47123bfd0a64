"""Machines as JSON and back: data in, data out, no code is run."""
