"""Vector fields of machines: Lie brackets, distributions and controllability."""
