"""What a motion costs, where a scenario's [objective] says something else than its duration."""
