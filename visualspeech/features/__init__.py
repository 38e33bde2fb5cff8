"""Streams of one frame rate that models learn from: labels and resampled visual features."""
