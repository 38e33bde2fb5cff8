"""Fitting of the appearance model to frames without landmarks, or with coarse ones."""

from visualspeech.face.aam.fitting.model import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.solver import Fit, fit, follow

__all__ = ["Fit", "FittingModel", "FittingSettings", "fit", "follow"]
