"""Phone HMMs over appearance and its changes in time, and what they generate: the baseline of Table 3."""
