"""What a machine says about its control: a law of its own, and flat outputs."""
