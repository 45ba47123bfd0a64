"""Work that others do or stop: processes started, at work and ended, and cancellation."""
