"""Faces as points: controls for other animation systems, and drawings with sound."""
