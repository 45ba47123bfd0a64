"""The problem of another machine: without masses, alone with what stands still, one of several."""
