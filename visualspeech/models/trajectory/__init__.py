"""Trajectories from static, delta and delta-delta values: windows, and maximum-likelihood generation (MLPG)."""
