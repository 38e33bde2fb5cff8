"""Predictions that a network must beat: the training mean, and the mean of each phone state or triphone state."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.features.labels import STATES
from visualspeech.fields import Settings, restored, setting
from visualspeech.storage import part_of, read_model_of, write_model

KINDS = ("training_mean", "phone_state_mean", "triphone_state_mean")

# The parts of a label (left, current, right, state) that a table of means looks at.
_LOOKS = {"triphone": (0, 1, 2, 3), "left": (0, 1, 3), "right": (1, 2, 3), "phone": (1, 3)}


@dataclass(frozen=True)
class BaselineSettings(Settings):
    """Trivial baselines: means of the training frames."""

    section = "baselines"
    min_count: int = setting(
        3,
        "Minimum number of training frames behind a mean; rarer labels back off to the next coarser mean.",
        minimum=1,
        maximum=1_000_000,
    )


@dataclass(frozen=True)
class Baseline:
    """A look-up from a frame's label to the mean appearance of training frames like it.

    ``training_mean`` has one mean. ``phone_state_mean`` has one for each phone and state. ``triphone_state_mean`` has
    one for each left phone, phone, right phone and state; where training has fewer than ``min_count`` such frames, it
    backs off in three steps, each with the same condition:

    1. the two-phone context nearest in time: (left, phone, state) in the first state and (phone, right, state) in the
       last; in the middle state the one that rests on more frames (left on a tie); where the nearest is too rare, the
       other one
    2. (phone, state)
    3. the training mean

    Parameters
    ----------
    kind : one of :data:`KINDS`
    settings : when a mean counts
    phones : size K of the inventory
    mean : (N,) training mean
    codes, means : by context (``triphone``, ``left``, ``right``, ``phone``): sorted codes (n,) int64, means (n, N)
    counts : by context: training frames (n,) int64 of each mean
    """

    kind: str
    settings: BaselineSettings
    phones: int
    mean: np.ndarray
    codes: Mapping[str, np.ndarray]
    means: Mapping[str, np.ndarray]
    counts: Mapping[str, np.ndarray]

    def predict(self, labels: np.ndarray) -> np.ndarray:
        """Appearance (T, N) float32 of labels (T, 4)."""
        labels = np.asarray(labels, dtype=np.int64)
        result = np.tile(self.mean, (len(labels), 1))
        waiting = np.ones(len(labels), dtype=bool)
        for context, chosen in self._order(labels):
            row, count = self._find(context, labels)
            use = waiting & chosen & (count >= self.settings.min_count)
            result[use] = self.means[context][row[use]]
            waiting &= ~use
        return result.astype(np.float32)

    def _order(self, labels: np.ndarray) -> list[tuple[str, np.ndarray]]:
        """Contexts in the order in which they are asked, and the frames that each is asked for."""
        everywhere = np.ones(len(labels), dtype=bool)
        phone = [("phone", everywhere)]
        if self.kind != "triphone_state_mean":
            return phone if self.kind == "phone_state_mean" else []
        state = labels[:, 3]
        more_left = self._find("left", labels)[1] >= self._find("right", labels)[1]
        left_first = (state == 0) | ((state == 1) & more_left)
        nearest = [("left", left_first), ("right", ~left_first)]
        other = [("right", left_first), ("left", ~left_first)]
        return [("triphone", everywhere), *nearest, *other, *phone]

    def _find(self, context: str, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Row of each frame's mean in a context's table, and the frames it rests on; 0 where there is none."""
        codes = self.codes[context]
        wanted = _code(labels, context, self.phones)
        row = np.minimum(np.searchsorted(codes, wanted), len(codes) - 1)
        return row, np.where(codes[row] == wanted, self.counts[context][row], 0)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        tensors = {"mean": self.mean}
        for part, tables in (("codes", self.codes), ("means", self.means), ("counts", self.counts)):
            tensors |= {f"{part}.{context}": values for context, values in tables.items()}
        write_model(path, tensors, {"kind": self.kind, "phones": self.phones, "baseline": asdict(self.settings)})

    @staticmethod
    def load(path: str | Path) -> "Baseline":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.read_model_of`."""
        tensors, settings = read_model_of(path, "baseline", KINDS)
        return Baseline(
            settings["kind"],
            restored(BaselineSettings, settings["baseline"], path),
            settings["phones"],
            tensors["mean"],
            *(part_of(tensors, part) for part in ("codes", "means", "counts")),
        )


def fit(
    kind: str,
    training: Sequence[tuple[np.ndarray, np.ndarray]],
    phones: int,
    settings: BaselineSettings | None = None,
) -> Baseline:
    """Means of the training utterances, in one pass.

    Parameters
    ----------
    kind : ``training_mean``, ``phone_state_mean`` or ``triphone_state_mean``
    training : utterances as (labels (T, 4), appearance (T, N))
    phones : size K of the inventory
    settings : when a mean counts

    Raises
    ------
    SettingError
        The kind is unknown.
    DataError
        There is no training utterance.
    """
    if kind not in KINDS:
        raise SettingError(f"the baseline {kind!r} is unknown. Known: {', '.join(KINDS)}.")
    if not len(training):
        raise DataError("there is no training utterance to take means of. Add recordings, or change `split`.")
    looks = {"training_mean": (), "phone_state_mean": ("phone",), "triphone_state_mean": tuple(_LOOKS)}[kind]
    sums: dict[str, dict[int, np.ndarray]] = {context: {} for context in looks}
    total, frames = 0.0, 0
    for number in range(len(training)):
        labels, values = training[number]
        labels, values = np.asarray(labels, np.int64), np.asarray(values, np.float64)
        total, frames = total + values.sum(axis=0), frames + len(values)
        for context in looks:
            # Each entry holds the sum of the frames and, last, their number.
            codes, place = np.unique(_code(labels, context, phones), return_inverse=True)
            part = np.zeros((len(codes), values.shape[1] + 1))
            np.add.at(part, place, np.column_stack([values, np.ones(len(values))]))
            table = sums[context]
            for code, row in zip(codes.tolist(), part, strict=True):
                table[code] = table[code] + row if code in table else row
    tables = {context: _sorted(table) for context, table in sums.items()}
    return Baseline(
        kind=kind,
        settings=settings or BaselineSettings(),
        phones=phones,
        mean=total / frames,
        codes={context: table[0] for context, table in tables.items()},
        means={context: table[1] for context, table in tables.items()},
        counts={context: table[2] for context, table in tables.items()},
    )


def _sorted(table: dict[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    codes = sorted(table)
    rows = np.array([table[code] for code in codes])
    return np.array(codes, np.int64), rows[:, :-1] / rows[:, -1:], rows[:, -1].astype(np.int64)


def _code(labels: np.ndarray, context: str, phones: int) -> np.ndarray:
    """One number for the parts of a label that a context looks at."""
    sizes = (phones, phones, phones, STATES)
    looks = _LOOKS[context]
    return np.ravel_multi_index([labels[:, part] for part in looks], [sizes[part] for part in looks])
