"""Look-up baselines that a network must beat: the mean of each phone state or triphone state of training frames."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.fields import restored
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.lookup_settings import LookupSettings
from visualspeech.models.task import Fitted, Task, check_examples, check_streams
from visualspeech.storage.layouts import RATE, TEXT, Array, FileLayout, check_arrays
from visualspeech.storage.models import check_model, part_of, read_model, write_model

FAMILY = "lookup"

# The columns of a label (left, current, right phone, state) that a table of means looks at.
_COLUMNS = {"triphone": (0, 1, 2, 3), "left": (0, 1, 3), "right": (1, 2, 3), "phone": (1, 3)}


@dataclass(frozen=True)
class Lookup:
    """A look-up from a frame's label to the mean target of training frames with the same label.

    The context ``phone`` has one mean for each phone and state. ``triphone`` has one for each left phone, phone, right
    phone and state; where training has fewer than ``min_count`` such frames, it backs off in three steps, each with the
    same condition:

    1. the two-phone context nearest in time: (left, phone, state) in the first state and (phone, right, state) in the
       last; in the middle state the one that rests on more frames (left on a tie); where the nearest is too rare, the
       other one
    2. (phone, state)
    3. the training mean

    Parameters
    ----------
    settings : context, and when a mean counts
    sizes : (4,) classes of the label's columns
    mean : (N,) training mean
    codes, means : by context (``triphone``, ``left``, ``right``, ``phone``): sorted codes (n,) int64, means (n, N)
    counts : by context: training frames (n,) int64 of each mean
    blocks : the one block that it reads, of kind ``triphone_state``
    rate : frame rate of the training utterances in Hz
    coding : digest of the visual coding
    """

    settings: LookupSettings
    sizes: tuple[int, ...]
    mean: np.ndarray
    codes: Mapping[str, np.ndarray]
    means: Mapping[str, np.ndarray]
    counts: Mapping[str, np.ndarray]
    blocks: Mapping[str, Block] = field(default_factory=dict)
    rate: float = 25.0
    coding: str = ""

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return len(self.mean)

    def predict(self, streams: Sequence[Stream], frames: int = 0, rate: float = 0.0) -> np.ndarray:
        """Parameters (T, N) float32 of the labels of T frames."""
        if self.blocks:
            check_streams(streams, self.blocks)
        labels = np.asarray(streams[0].index, dtype=np.int64)
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
        if self.settings.context == "phone":
            return phone
        state = labels[:, 3]
        more_left = self._find("left", labels)[1] >= self._find("right", labels)[1]
        left_first = (state == 0) | ((state == 1) & more_left)
        nearest = [("left", left_first), ("right", ~left_first)]
        other = [("right", left_first), ("left", ~left_first)]
        return [("triphone", everywhere), *nearest, *other, *phone]

    def _find(self, context: str, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Row of each frame's mean in a context's table, and the frames it rests on; 0 where there is none."""
        codes = self.codes[context]
        wanted = _code(labels, context, self.sizes)
        row = np.minimum(np.searchsorted(codes, wanted), len(codes) - 1)
        return row, np.where(codes[row] == wanted, self.counts[context][row], 0)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        arrays, blocks = pack(self.blocks)
        arrays["mean"] = self.mean
        for part, tables in (("codes", self.codes), ("means", self.means), ("counts", self.counts)):
            arrays |= {f"{part}.{context}": values for context, values in tables.items()}
        settings = {
            "kind": "model",
            "family": FAMILY,
            "settings": asdict(self.settings),
            "sizes": list(self.sizes),
            "blocks": blocks,
            "rate": self.rate,
            "coding": self.coding,
        }
        write_model(path, arrays, settings)


def fit(task: Task) -> Fitted:
    """Means of the training utterances.

    Raises
    ------
    DataError
        There is no training utterance, or the row reads another block than one of kind ``triphone_state``.
    """
    import pandas

    sizes = [block.layout.sizes for block in task.blocks.values()]
    if len(sizes) != 1 or len(sizes[0]) != 4:
        raise DataError(
            f"`models.{task.row.name}.reads` must name one block of kind triphone_state that is not fractional."
        )
    check_examples(task.training, task.blocks, "training")
    model = fit_lookup(task.training, sizes[0], LookupSettings(**task.row.settings), task.blocks, task.coding)
    counts = {context: len(values) for context, values in model.counts.items()}
    return Fitted(model, pandas.DataFrame({"figure": list(counts), "value": list(counts.values())}))


def fit_lookup(
    training: Sequence[Example],
    sizes: Sequence[int],
    settings: LookupSettings | None = None,
    blocks: Mapping[str, Block] | None = None,
    coding: str = "",
) -> Lookup:
    """Means of training utterances whose first stream holds labels (T, 4) of ``sizes`` classes, in one pass."""
    settings = settings or LookupSettings()
    contexts = ("phone",) if settings.context == "phone" else tuple(_COLUMNS)
    sums: dict[str, dict[int, np.ndarray]] = {context: {} for context in contexts}
    total, frames = 0.0, 0
    for number in range(len(training)):
        streams, target, rate = training[number]
        labels, values = np.asarray(streams[0].index, np.int64), np.asarray(target, np.float64)
        total, frames = total + values.sum(axis=0), frames + len(values)
        for context in contexts:
            # Each entry holds the sum of the frames and, last, their number.
            codes, place = np.unique(_code(labels, context, sizes), return_inverse=True)
            part = np.zeros((len(codes), values.shape[1] + 1))
            np.add.at(part, place, np.column_stack([values, np.ones(len(values))]))
            table = sums[context]
            for code, row in zip(codes.tolist(), part, strict=True):
                table[code] = table[code] + row if code in table else row
    tables = {context: _sorted(table) for context, table in sums.items()}
    return Lookup(
        settings=settings,
        sizes=tuple(sizes),
        mean=total / frames,
        codes={context: table[0] for context, table in tables.items()},
        means={context: table[1] for context, table in tables.items()},
        counts={context: table[2] for context, table in tables.items()},
        blocks=blocks or {},
        rate=float(rate),
        coding=coding,
    )


def load(path: str | Path) -> Lookup:
    """Read a saved look-up; raises as :func:`restore`."""
    return restore(*read_model(path), path)


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Lookup:
    """The look-up in a file's content; raises as :func:`visualspeech.storage.models.check_model`."""
    check_model(arrays, settings, path, "look-up of means", ["model"], LAYOUT, FAMILY)
    made = Lookup(
        restored(LookupSettings, settings["settings"], path),
        tuple(map(int, settings["sizes"])),
        arrays["mean"],
        *(part_of(arrays, part) for part in ("codes", "means", "counts")),
        unpack(arrays, settings["blocks"], path),
        settings["rate"],
        settings["coding"],
    )
    _check_tables(path, made)
    return made


_SIZES = {
    "type": "array",
    "minItems": 4,
    "maxItems": 4,
    "items": {"type": "integer", "minimum": 1, "maximum": 10_000},
}
LAYOUT = FileLayout(
    {
        "mean": Array("f", ("N",)),
        "codes.*": Array("iu", None, 0, 1e18),
        "means.*": Array("f", None),
        "counts.*": Array("iu", None, 1, 1e18),
        **BLOCK_ARRAYS,
    },
    {"settings": {"type": "object"}, "sizes": _SIZES, "blocks": BLOCKS, "rate": RATE, "coding": TEXT},
)


def _check_tables(path, made: Lookup) -> None:
    """Refuse tables of means that do not fit each other, the contexts or the block."""
    contexts = ("phone",) if made.settings.context == "phone" else tuple(_COLUMNS)
    for part in (made.codes, made.means, made.counts):
        if set(part) != set(contexts):
            raise DamagedFile(path, f"it has tables of means for the contexts {', '.join(sorted(part))}")
    for context in contexts:
        most = np.prod([made.sizes[column] for column in _COLUMNS[context]], dtype=np.float64) - 1
        tables = {"codes": made.codes[context], "means": made.means[context], "counts": made.counts[context]}
        layout = {
            "codes": Array("iu", ("M",), 0, most),
            "means": Array("f", ("M", "N")),
            "counts": Array("iu", ("M",), 1, 1e18),
        }
        check_arrays(path, tables, layout, {"N": made.outputs})
        if (np.diff(tables["codes"].astype(np.int64)) <= 0).any():
            raise DamagedFile(path, f"its means for the context {context} are not sorted")
    if [block.layout.sizes for block in made.blocks.values()] != [made.sizes]:
        raise DamagedFile(path, "its classes are not those of its input block")


def _sorted(table: dict[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    codes = sorted(table)
    rows = np.array([table[code] for code in codes])
    return np.array(codes, np.int64), rows[:, :-1] / rows[:, -1:], rows[:, -1].astype(np.int64)


def _code(labels: np.ndarray, context: str, sizes: Sequence[int]) -> np.ndarray:
    """One number for the columns of a label that a context looks at."""
    columns = _COLUMNS[context]
    return np.ravel_multi_index([labels[:, column] for column in columns], [sizes[column] for column in columns])
