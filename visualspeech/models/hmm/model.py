"""Phone HMMs as a model of a run: what prediction needs, in one safetensors file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.resampling import resample
from visualspeech.fields import MAX_SEED, Settings, restored, setting
from visualspeech.models.hmm.chains import timed_states
from visualspeech.models.hmm.generation import Trajectory, generate
from visualspeech.models.hmm.segments import PhoneTrack
from visualspeech.models.hmm.statistics import Gaussians
from visualspeech.models.hmm.tying import Tying
from visualspeech.storage import part_of, read_model_of, write_model
from visualspeech.timing import frames_in


@dataclass(frozen=True)
class HmmSettings(Settings):
    """Phone HMMs: monophone, tied-state triphone and MGE-trained (Fan 2015, section 5.3, Table 3).

    The paper gives each phone five states. A phone hardly lasts longer than a frame of video, so streams are resampled
    to a higher rate.
    """

    section = "hmm"
    states: int = setting(5, "Number of states per phone, left to right.", minimum=1, maximum=20)
    rate: float = setting(100.0, "Frame rate of the HMMs in Hz; streams are resampled to it.", minimum=1, maximum=1000)
    delta_step: float = setting(
        0.04, "Time between the taps of the delta windows, in seconds.", minimum=0.0001, maximum=1
    )
    monophone_iterations: int = setting(2, "Baum-Welch iterations of the monophone HMMs.", minimum=0, maximum=1000)
    untied_iterations: int = setting(
        1, "Baum-Welch iterations of the triphone HMMs before their states are tied.", minimum=1, maximum=1000
    )
    tied_iterations: int = setting(3, "Baum-Welch iterations of the tied-state triphone HMMs.", minimum=0, maximum=1000)
    map_tau: float = setting(
        10.0,
        "Weight tau of the MAP estimate of untied triphone Gaussians: number of frames that the monophone's Gaussian "
        "counts for.",
        minimum=0,
        maximum=1_000_000,
    )
    mdl_factor: float = setting(
        0.1,
        "Factor on the description length that stops the growth of the decision trees; 1 as published, smaller gives "
        "more Gaussians.",
        minimum=0,
        maximum=1000,
    )
    min_frames: float = setting(
        5.0,
        "Minimum occupancy of a tied Gaussian, in frames of the video.",
        minimum=1,
        maximum=1_000_000,
    )
    tree_per_phone: bool = setting(
        False, "Grow one decision tree per state and phone; otherwise one per state, shared by all phones."
    )
    variance_floor: float = setting(
        0.01,
        "Minimum variance of a Gaussian, as a share of the variance over all frames.",
        minimum=0.000001,
        maximum=1,
    )
    mge_epochs: int = setting(
        20, "Maximum number of epochs of minimum generation error (MGE) training.", minimum=1, maximum=100_000
    )
    mge_learning_rate: float = setting(
        0.01,
        "Learning rate of MGE training, in standard deviations of each Gaussian.",
        minimum=0.00000001,
        maximum=100,
    )
    mge_batch_size: int = setting(8, "Number of utterances per update of MGE training.", minimum=1, maximum=100_000)
    mge_patience: int = setting(
        3,
        "Number of epochs without a lower validation error after which MGE training stops.",
        minimum=1,
        maximum=100_000,
    )
    mge_variances: bool = setting(True, "Train the variances by MGE too, not only the means.")
    seed: int = setting(1, "Seed of the order of the utterances in MGE training.", minimum=0, maximum=MAX_SEED)

    @property
    def step(self) -> int:
        """Frames between the taps of the windows."""
        return max(round(self.delta_step * self.rate), 1)


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
            settings=restored(HmmSettings, settings["hmm"], path),
            phones=tuple(settings["phones"]),
            tying=Tying(**part_of(tensors, "tying")),
            gaussians=Gaussians(**part_of(tensors, "gaussians")),
            stay=tensors["stay"],
            aam=settings["aam"],
            about=settings["about"],
        )
