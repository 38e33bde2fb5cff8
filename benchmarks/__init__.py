"""Figures of speed and accuracy; every benchmark runs on one thread, as the workflow's jobs do."""

from pathlib import Path

from visualspeech.jobs import settle_environment

settle_environment(Path(__file__).resolve().parents[1])
