"""Trust-region sequential quadratic programming."""
