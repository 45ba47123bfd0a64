"""Trees that grow toward samples: those of RRT, SST and AO-RRT."""
