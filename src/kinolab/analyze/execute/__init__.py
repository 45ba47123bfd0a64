"""Closed-loop execution of plans on perturbed machines."""
