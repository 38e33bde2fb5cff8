"""Phone HMMs that predict appearance from phones with times, saved as one safetensors file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.resampling import at_times, back_from_means, back_from_times, resample
from visualspeech.fields import MAX_SEED, Settings, restored, setting
from visualspeech.models.hmm.chains import timed_states
from visualspeech.models.hmm.segments import ContextLayout, Factor, PhoneTrack, layout_text
from visualspeech.models.hmm.statistics import Gaussians
from visualspeech.models.hmm.tying import Tying
from visualspeech.models.trajectory.generation import Trajectory, check_generation, generate, step_of
from visualspeech.storage.layouts import PHONES, TEXT, Array
from visualspeech.storage.models import part_of
from visualspeech.timing import frame_times, frames_in


@dataclass(frozen=True)
class HmmSettings(Settings):
    """Phone HMMs: monophone, tied-state and MGE-trained (Fan 2015, section 5.3, Table 3; Thangthai 2016, section 5.2).

    The paper gives each phone five states. A phone hardly lasts longer than a frame of video, so streams are resampled
    to a higher rate.
    """

    section = "models"
    variant: str = setting(
        "monophone",
        "Stage of training: monophone, tied (tied states of phones in context), mge (minimum generation error).",
        choices=("monophone", "tied", "mge"),
    )
    durations: str = setting(
        "geometric",
        "Durations of states in training: geometric (HMM, self-transition probabilities) or gaussian (hidden "
        "semi-Markov model: a Gaussian per state, as in generation).",
        choices=("geometric", "gaussian"),
    )
    states: int = setting(5, "Number of states per phone, left to right.", minimum=1, maximum=20)
    rate: float = setting(100.0, "Frame rate of the HMMs in Hz; streams are resampled to it.", minimum=1, maximum=1000)
    delta_step: float = setting(
        0.04, "Time between the taps of the delta windows, in seconds.", minimum=0.0001, maximum=1
    )
    reading: str = setting(
        "mean",
        "How a generated trajectory becomes frames: its mean over each frame, or its value at the frame's centre.",
        choices=("mean", "centre"),
    )
    monophone_iterations: int = setting(2, "Baum-Welch iterations of the monophone HMMs.", minimum=0, maximum=1000)
    untied_iterations: int = setting(
        1,
        "Baum-Welch iterations of the HMMs of phones in context before their states are tied.",
        minimum=1,
        maximum=1000,
    )
    tied_iterations: int = setting(3, "Baum-Welch iterations of the tied-state HMMs.", minimum=0, maximum=1000)
    map_tau: float = setting(
        10.0,
        "Weight tau of the MAP estimate of untied Gaussians of phones in context: number of frames that the "
        "monophone's Gaussian counts for.",
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
        "Minimum occupancy of a tied Gaussian, in frames at the rate of the system.",
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
    mge_offset_weight: float = setting(
        1.0,
        "Weight of the squared mean error of an utterance in MGE training; 1 gives the plain squared error, 0 ignores "
        "the mean.",
        minimum=0,
        maximum=1,
    )
    mge_variances: bool = setting(True, "Train the variances by MGE too, not only the means.")
    seed: int = setting(1, "Seed of the order of the utterances in MGE training.", minimum=0, maximum=MAX_SEED)

    @property
    def step(self) -> int:
        """Frames between the taps of the windows."""
        return step_of(self.delta_step, self.rate)


@dataclass(frozen=True)
class Hmm:
    """HMMs of all phones, which predict appearance parameters from phones with times.

    Parameters
    ----------
    settings : structure, training, and the variant: ``monophone``, ``tied`` or ``mge``
    phones : inventory that the indices refer to, K entries
    tying : from a phone in context and a state to a Gaussian
    gaussians : distributions of the states
    self_transition : (K, S) self-transition probabilities; used by training with geometric durations only
    about : how the HMMs were trained, for people; ``history`` is a list of (stage, round, figure, value)
    """

    settings: HmmSettings
    phones: tuple[str, ...]
    tying: Tying
    gaussians: Gaussians
    self_transition: np.ndarray
    about: Mapping = field(default_factory=dict)

    def states_of(self, contexts: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Gaussian of every frame (T,) of phones in context (P, C), or divisions of them, of ``lengths`` (P,) frames.

        Each of them is divided among its states by their durations
        (:func:`visualspeech.models.hmm.chains.timed_states`).
        """
        chosen = self.tying.find(contexts)
        here = self.gaussians.at(chosen)
        states = timed_states(lengths, here.duration_mean, here.duration_variance)
        return chosen[np.repeat(np.arange(len(lengths)), lengths), states]

    def trajectory(self, gaussians: np.ndarray) -> Trajectory:
        """The stream that is generated by one Gaussian per frame (T,), at the rate of the HMMs."""
        return generate(self.gaussians.mean[gaussians], 1 / self.gaussians.variance[gaussians], self.settings.step)

    def predict(self, track: PhoneTrack, frames: int, rate: float) -> np.ndarray:
        """Values (frames, N) float32 at ``rate`` Hz for the phones of an utterance.

        Raises
        ------
        DataError
            There is no frame, a phone is outside the inventory, or the phone contexts have another layout than those
            that the HMMs were trained on.
        """
        if frames < 1:
            raise DataError("there is no frame to predict; the utterance is empty.")
        if track.layout != self.tying.layout:
            raise DataError(
                f"the phone contexts of the utterance have {layout_text(track.layout)}; those of the HMMs have "
                f"{layout_text(self.tying.layout)}."
            )
        sizes = np.array(track.layout.sizes(len(self.phones)))
        outside = ((track.contexts < 0) | (track.contexts >= sizes)).any(axis=0)
        if outside[: track.columns].any():
            raise DataError(f"the utterance has phones that are not among the {len(self.phones)} phones of the HMMs.")
        if outside.any():
            raise DataError("the utterance has positions or numbers of units that are larger than those of the HMMs.")
        values = self.trajectory(self.states_at(track, frames, rate)).values
        return self.read(values, frames, rate).astype(np.float32)

    def states_at(self, track: PhoneTrack, frames: int, rate: float) -> np.ndarray:
        """Gaussian of every frame at the rate of the HMMs, of an utterance of ``frames`` frames at ``rate`` Hz."""
        inner = max(frames_in(frames / rate, self.settings.rate), 1)
        return self.states_of(*track.runs(inner, self.settings.rate))

    def read(self, values: np.ndarray, frames: int, rate: float) -> np.ndarray:
        """The ``frames`` frames at ``rate`` Hz that a generated stream (T, N) gives: (frames, N)."""
        if self.settings.reading == "mean":
            return resample(values, self.settings.rate, rate, frames)
        return at_times(values, self.settings.rate, frame_times(frames, rate))

    def back(self, errors: np.ndarray, length: int, rate: float) -> np.ndarray:
        """The transpose of :meth:`read`: derivatives (length, N) by the stream, from those by its frames."""
        if self.settings.reading == "mean":
            return back_from_means(errors, length, self.settings.rate, rate)
        return back_from_times(errors, length, self.settings.rate, frame_times(len(errors), rate))

    def history_table(self):
        """History of the training as a data frame: stage, round, figure, value."""
        import pandas

        return pandas.DataFrame(list(self.about.get("history", [])), columns=["stage", "round", "figure", "value"])

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        """The HMMs as arrays and plain data, see :meth:`restore`."""
        arrays = {"self_transition": self.self_transition}
        for part in ("tying", "gaussians"):
            own = {name: one for name, one in vars(getattr(self, part)).items() if isinstance(one, np.ndarray)}
            arrays |= {f"{part}.{name}": values for name, values in own.items()}
        plain = {
            "settings": asdict(self.settings),
            "phones": list(self.phones),
            "contexts": {
                **self.tying.layout._asdict(),
                "factors": [factor._asdict() for factor in self.tying.factors],
            },
            "about": dict(self.about),
        }
        return arrays, plain

    @staticmethod
    def restore(arrays: Mapping[str, np.ndarray], plain: Mapping, path: str | Path = "") -> "Hmm":
        """The inverse of :meth:`state`, for content of the file ``path`` that fits :data:`ARRAYS` and :data:`PLAIN`.

        Raises
        ------
        StorageError
            The settings, the trees or the Gaussians do not fit each other.
        """
        contexts = plain["contexts"]
        layout = ContextLayout(
            **{name: int(contexts[name]) for name in ("columns", "centre", "divisions")},
            factors=tuple(Factor(one["name"], int(one["values"])) for one in contexts["factors"]),
        )
        hmm = Hmm(
            settings=restored(HmmSettings, plain["settings"], path),
            phones=tuple(plain["phones"]),
            tying=Tying(**part_of(arrays, "tying"), **layout._asdict()),
            gaussians=Gaussians(**part_of(arrays, "gaussians")),
            self_transition=arrays["self_transition"],
            about=plain["about"],
        )
        _check(path, hmm)
        return hmm


#: K phones, V values of a column of contexts at most, S states, Q nodes of trees, M Gaussians of N parameters.
ARRAYS = {
    "self_transition": Array("f", ("K", "S"), 0, 1),
    "tying.roots": Array("i", ("S", "K")),
    "tying.positions": Array("i", ("Q?",), 0),
    "tying.members": Array("b", ("Q?", "V")),
    "tying.branches": Array("i", ("Q?", 2)),
    "gaussians.mean": Array("f", ("M", "3N"), -1e9, 1e9),
    "gaussians.variance": Array("f", ("M", "3N"), 1e-15),
    "gaussians.duration_mean": Array("f", ("M",), 1e-9, 1e9),
    "gaussians.duration_variance": Array("f", ("M",), 1e-9, 1e9),
}
PLAIN = {
    "type": "object",
    "required": ["settings", "phones", "contexts", "about"],
    "additionalProperties": False,
    "properties": {
        "settings": {"type": "object"},
        "phones": PHONES,
        "contexts": {
            "type": "object",
            "required": ["columns", "centre", "divisions", "factors"],
            "additionalProperties": False,
            "properties": {
                "columns": {"type": "integer", "minimum": 1, "maximum": 99},
                "centre": {"type": "integer", "minimum": 0, "maximum": 98},
                "divisions": {"type": "integer", "minimum": 1, "maximum": 99},
                "factors": {
                    "type": "array",
                    "maxItems": 200,
                    "items": {
                        "type": "object",
                        "required": ["name", "values"],
                        "additionalProperties": False,
                        "properties": {"name": TEXT, "values": {"type": "integer", "minimum": 1, "maximum": 1000}},
                    },
                },
            },
        },
        "about": {"type": "object"},
    },
}


def _check(path, hmm: Hmm) -> None:
    """Refuse trees that never end or lead to no Gaussian, and Gaussians from which no stream can be generated."""
    tying, count = hmm.tying, len(hmm.gaussians.mean)
    nodes = len(tying.positions)
    if len(hmm.phones) != tying.roots.shape[1] or hmm.settings.states != tying.roots.shape[0]:
        raise DamagedFile(path, "its phones or states are not those of its trees")
    if tying.members.shape[1] != max(tying.layout.sizes(len(hmm.phones))[: tying.columns + len(tying.factors)]):
        raise DamagedFile(path, "the questions of its trees are not about its phones and numbers")
    if hmm.settings.states % tying.divisions:
        raise DamagedFile(path, "its states cannot be shared out over the divisions of a phone")
    targets = np.concatenate([tying.roots.ravel(), tying.branches.ravel()])
    # A branch leads on to a later node, so every way through a tree ends.
    onward = (tying.branches < 0) | (tying.branches > np.arange(nodes)[:, None])
    asked = tying.positions < tying.columns + len(tying.factors)
    if targets.min() < -count or targets.max() >= nodes or not onward.all() or not asked.all():
        raise DamagedFile(path, "its trees lead to no Gaussian")
    check_generation(path, hmm.gaussians.variance, hmm.settings.step)
