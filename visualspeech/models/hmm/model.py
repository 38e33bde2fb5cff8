"""Phone HMMs as a model of a run: what prediction needs, in one safetensors file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.features.resampling import resample
from visualspeech.models.hmm.chains import timed_states
from visualspeech.models.hmm.generation import Trajectory, generate
from visualspeech.models.hmm.segments import PhoneTrack
from visualspeech.models.hmm.statistics import Gaussians
from visualspeech.models.hmm.tying import Tying
from visualspeech.storage import part_of, read_model_of, write_model
from visualspeech.timing import frames_in


@dataclass(frozen=True)
class HmmSettings:
    """How HMMs are built and trained.

    Parameters
    ----------
    states : of each phone, left to right (Fan 2015, section 5.3: five)
    rate : frame rate of the HMMs in Hz; streams are resampled to it, since a phone lasts hardly longer than a frame of
        video
    window : seconds between the taps of the delta windows
    monophone_iterations, untied_iterations, tied_iterations : of Baum-Welch; the first of the untied models is made
        with the monophones' probabilities of states
    untied_weight : frames of the monophone that each untied Gaussian is held to it by
    mdl : weight of the description length that ends the trees
    min_frames : frames of video that a tied Gaussian must rest on
    of_each_phone : a tree for each state of each phone, else for each state of all phones
    variance_floor : least variance, as a share of the variance over all frames
    mge_epochs : epochs of minimum generation error training at most
    mge_learning_rate : its step size, in standard deviations of each Gaussian
    mge_batch : utterances an update
    mge_patience : epochs without a lower validation error after which it ends
    mge_variances : refine the variances too
    seed : of the order of the utterances
    """

    states: int = 5
    rate: float = 100.0
    window: float = 0.04
    monophone_iterations: int = 2
    untied_iterations: int = 1
    tied_iterations: int = 3
    untied_weight: float = 10.0
    mdl: float = 0.1
    min_frames: float = 5.0
    of_each_phone: bool = False
    variance_floor: float = 0.01
    mge_epochs: int = 20
    mge_learning_rate: float = 0.01
    mge_batch: int = 8
    mge_patience: int = 3
    mge_variances: bool = True
    seed: int = 1

    def __post_init__(self) -> None:
        least = {
            "states": 1,
            "monophone_iterations": 0,
            "untied_iterations": 1,
            "tied_iterations": 0,
            "untied_weight": 0,
            "mdl": 0,
            "min_frames": 1,
            "mge_epochs": 1,
            "mge_batch": 1,
            "mge_patience": 1,
        }
        for name, limit in least.items():
            if getattr(self, name) < limit:
                raise SettingError(f"`hmm.{name}: {getattr(self, name)}` must be at least {limit}.")
        for name in ("rate", "window", "variance_floor", "mge_learning_rate"):
            if getattr(self, name) <= 0:
                raise SettingError(f"`hmm.{name}: {getattr(self, name)}` must be above 0.")

    @property
    def step(self) -> int:
        """Frames between the taps of the windows."""
        return max(round(self.window * self.rate), 1)


@dataclass(frozen=True)
class Hmm:
    """HMMs of all phones, from phones with times to appearance parameters.

    Parameters
    ----------
    kind : ``monophone``, ``tied`` or ``mge``
    settings : how it was built
    phones : inventory that the indices refer to, K entries
    tying : which Gaussian a state of a triphone has
    gaussians : the states
    stay : (K, S) probability of staying in a state; only training looks at it
    aam : digest of the appearance model whose parameters are predicted
    about : how it was trained, for people; ``history`` is a list of (stage, round, figure, value)
    """

    kind: str
    settings: HmmSettings
    phones: tuple[str, ...]
    tying: Tying
    gaussians: Gaussians
    stay: np.ndarray
    aam: str = ""
    about: Mapping = field(default_factory=dict)

    def states_of(self, triphones: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Gaussian of every frame (T,) of phones (P, 3) that last ``lengths`` (P,) frames.

        The time of a phone is shared out among its states by their durations
        (:func:`visualspeech.models.hmm.chains.timed_states`).
        """
        chosen = self.tying.find(triphones)
        here = self.gaussians.at(chosen)
        states = timed_states(lengths, here.duration_mean, here.duration_variance)
        return chosen[np.repeat(np.arange(len(lengths)), lengths), states]

    def trajectory(self, gaussians: np.ndarray) -> Trajectory:
        """The stream that a Gaussian for every frame (T,) generates, at the HMMs' rate."""
        return generate(self.gaussians.mean[gaussians], 1 / self.gaussians.variance[gaussians], self.settings.step)

    def predict(self, track: PhoneTrack, frames: int, rate: float) -> np.ndarray:
        """Appearance (frames, N) float32 at ``rate`` Hz of an utterance's phones.

        Raises
        ------
        DataError
            There is no frame, or a phone is outside the inventory.
        """
        if frames < 1:
            raise DataError("there is no frame to predict; the utterance is empty.")
        if track.triphones.min() < 0 or track.triphones.max() >= len(self.phones):
            raise DataError(f"the utterance names phones that the model of {len(self.phones)} phones does not have.")
        inner = max(frames_in(frames / rate, self.settings.rate), 1)
        values = self.trajectory(self.states_of(*track.runs(inner, self.settings.rate))).values
        return resample(values, self.settings.rate, rate, frames).astype(np.float32)

    def history_table(self):
        """How training went, as a data frame: stage, round, figure, value."""
        import pandas

        return pandas.DataFrame(list(self.about.get("history", [])), columns=["stage", "round", "figure", "value"])

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        tensors = {"stay": self.stay}
        for part in ("tying", "gaussians"):
            tensors |= {f"{part}.{name}": values for name, values in vars(getattr(self, part)).items()}
        settings = {
            "kind": "hmm",
            "variant": self.kind,
            "hmm": asdict(self.settings),
            "phones": list(self.phones),
            "aam": self.aam,
            "about": dict(self.about),
        }
        write_model(path, tensors, settings)

    @staticmethod
    def load(path: str | Path) -> "Hmm":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.read_model_of`."""
        tensors, settings = read_model_of(path, "HMMs", ["hmm"])
        return Hmm(
            kind=settings["variant"],
            settings=HmmSettings(**settings["hmm"]),
            phones=tuple(settings["phones"]),
            tying=Tying(**part_of(tensors, "tying")),
            gaussians=Gaussians(**part_of(tensors, "gaussians")),
            stay=tensors["stay"],
            aam=settings["aam"],
            about=settings["about"],
        )
