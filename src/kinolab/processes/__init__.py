"""Other processes: how they are started, do their work and end; it imports only Python's own."""
