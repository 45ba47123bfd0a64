"""Studies: many runs of planners on scenarios, on one computer or a cluster, and what they show."""
