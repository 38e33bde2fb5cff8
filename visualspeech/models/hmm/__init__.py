"""Phone HMMs over appearance and its changes in time, and the trajectories that they generate: the baseline of Table 3."""
