"""Settings of the training loop that all networks share; without torch, for planning."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import ClassVar

from visualspeech.errors import SettingError
from visualspeech.fields import MAX_SEED, Settings, setting, setting_error

#: Objectives of :mod:`visualspeech.models.objectives`, and batchers of :mod:`visualspeech.models.batches`.
OBJECTIVES = ("sse", "sse_centred", "mse", "ccc")
BATCHERS = ("utterances", "frames", "shuffled_frames")
#: Batchers of single frames in random order, and objectives that are no sums over frames of whole utterances.
FRAME_BATCHERS = ("shuffled_frames",)
OF_FRAMES = ("sse", "mse", "ccc")

#: What an optimiser's preset changes against the defaults of :class:`TrainingSettings`.
PRESETS = {
    "adam": {},
    "paper": {
        "learning_rate": 1e-6,
        "lr_decay": 1.0,
        "max_grad_norm": 0.0,
        "initial_std": 0.1,
        "scaling": "none",
        "dropout": 0.0,
        "ema_decay": 0.0,
    },
}


@dataclass(frozen=True)
class TrainingSettings(Settings):
    """How a network is trained. The defaults are the ``adam`` preset; see :func:`training_settings`."""

    section: ClassVar[str] = "training"

    optimiser: str = setting(
        "adam",
        "Preset: adam, or the paper's gradient descent with momentum (Fan 2015, Eq. 11) from Gaussian weights.",
        choices=tuple(PRESETS),
    )
    objective: str = setting(
        "sse",
        "What training minimises: sse (half the sum of squared errors, Fan 2015, Eq. 9), sse_centred (the same of "
        "prediction and truth less their means over the utterance), mse (mean squared error), ccc (1 - concordance "
        "correlation coefficient).",
        choices=OBJECTIVES,
    )
    offset_weight: float = setting(
        0.05,
        "Weight of the squared mean error of an utterance, with `objective: sse_centred`; 1: sse.",
        minimum=0,
        maximum=1,
    )
    closure_weight: float = setting(
        0.0,
        "Weight of lips that are predicted more open than recorded where they close, in p, b, m, f and v; with "
        "`objective` sse or sse_centred. 1: the opening in such a frame counts as much as all parameters.",
        minimum=0,
        maximum=100,
    )
    open_weight: float = setting(
        0.0,
        "The same of lips that are predicted less open than recorded where they are most open, in the vowels aa, ae, "
        "aw, ay and eh.",
        minimum=0,
        maximum=100,
    )
    batcher: str = setting(
        "utterances",
        "How an update is batched: utterances (batch_size of them), frames (as many utterances as hold batch_frames), "
        "shuffled_frames (batch_frames single frames of all utterances, for models that predict each frame by itself).",
        choices=BATCHERS,
    )
    learning_rate: float = setting(
        2e-3,
        "Step size; with `optimiser: paper` of the summed error of a batch, with adam the error's scale does not "
        "matter.",
        above=0,
        maximum=1,
    )
    momentum: float = setting(
        0.9, "Momentum m of Fan 2015, Eq. 11; with adam the decay of the mean gradient.", minimum=0, below=1
    )
    batch_size: int = setting(8, "Utterances per update, with `batcher: utterances`.", minimum=1, maximum=1024)
    batch_frames: int = setting(
        4096,
        "Frames per update with `batcher: shuffled_frames`; at most as many with `batcher: frames`.",
        minimum=1,
        maximum=100_000,
    )
    max_epochs: int = setting(200, "Epochs at most.", minimum=1, maximum=100_000)
    patience: int = setting(
        8, "Epochs without a better validation error after which training ends.", minimum=1, maximum=100_000
    )
    min_improvement: float = setting(
        1e-4, "Smallest relative fall of the validation error that counts as better.", minimum=0, below=1
    )
    lr_decay: float = setting(
        0.5,
        "Factor on the learning rate after lr_patience epochs without a better validation error; 1: no decay.",
        above=0,
        maximum=1,
    )
    lr_patience: int = setting(
        4, "Epochs without a better validation error before the learning rate decays.", minimum=1, maximum=100_000
    )
    max_grad_norm: float = setting(
        1.0, "Gradient clipping: largest norm of the gradient; 0: no clipping.", minimum=0, maximum=1e9
    )
    initial_std: float = setting(
        0.0,
        "Standard deviation of the Gaussian that all weights start from; 0: torch's uniform initialisation by layer "
        "width.",
        minimum=0,
        maximum=100,
    )
    scaling: str = setting(
        "global",
        "How targets are scaled: global (less the training mean, over one standard deviation), dimension (over one "
        "for each dimension), none.",
        choices=("global", "dimension", "none"),
    )
    dropout: float = setting(
        0.3, "Share of hidden values set to zero in training, after each hidden layer.", minimum=0, below=1
    )
    weight_decay: float = setting(
        0.0,
        "Decay of the weights, decoupled from the gradient (Loshchilov and Hutter 2019).",
        minimum=0,
        maximum=1,
    )
    ema_decay: float = setting(
        0.99,
        "Decay per update of the exponential moving average of the weights, which is validated and kept; smaller in "
        "the first updates; 0: the weights themselves.",
        minimum=0,
        below=1,
    )
    seed: int = setting(1, "Seed of initial weights, order and dropout.", minimum=0, maximum=MAX_SEED)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.batcher not in FRAME_BATCHERS:
            return
        if self.objective not in OF_FRAMES:
            rule = f"{', '.join(OF_FRAMES)} with `batcher: {self.batcher}`, which knows no whole utterances"
            raise setting_error(type(self), "objective", self.objective, f"one of {rule}")
        for name in ("closure_weight", "open_weight"):
            if getattr(self, name):
                rule = f"0 with `batcher: {self.batcher}`, which knows no whole utterances"
                raise setting_error(type(self), name, getattr(self, name), rule)


def training_fields() -> list[str]:
    """Names of all settings of training."""
    return [one.name for one in fields(TrainingSettings)]


def training_settings(given: Mapping | None = None, **changes) -> TrainingSettings:
    """Settings of a preset (``optimiser``: ``adam`` or ``paper``), with changes.

    Raises
    ------
    SettingError
        The preset or a setting is unknown, or a value is out of range.
    """
    changes = {**(given or {}), **changes}
    optimiser = changes.get("optimiser", "adam")
    if optimiser not in PRESETS:
        raise SettingError(f"`training.optimiser: {optimiser}` must be one of {', '.join(PRESETS)}.")
    unknown = sorted(set(changes) - set(training_fields()))
    if unknown:
        known = ", ".join(training_fields())
        raise SettingError(f"unknown setting `training.{unknown[0]}`. Known here: {known}.")
    return TrainingSettings(**{**PRESETS[optimiser], **changes})
