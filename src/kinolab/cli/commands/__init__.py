"""One file per command: what is typed, and what is done."""
