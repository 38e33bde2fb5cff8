"""The table of lip statistics of a system: a line for each of its rows and test utterances."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from visualspeech.corpora.records import Utterance
from visualspeech.errors import DamagedFile
from visualspeech.evaluation.lip_statistics import at_frames, lip_statistics
from visualspeech.evaluation.tracked import TrackedSpeaker
from visualspeech.face.mouth import MouthNames, point_names
from visualspeech.models.size import parameter_count
from visualspeech.models.speed import read_speed
from visualspeech.speech.alignment import Alignment
from visualspeech.storage.models import read_model
from visualspeech.storage.tables import read_table


def lip_rows(
    row: str,
    utterances: Sequence[Utterance],
    predictions,
    faces,
    coding,
    mouth: MouthNames,
    names: Sequence[str],
    alignments: Mapping[str, Alignment],
    speakers: Mapping[str, TrackedSpeaker],
) -> Iterator[dict]:
    """The lines of one row.

    Parameters
    ----------
    row : its name
    utterances : test utterances
    predictions : opened file of predicted ``appearance`` at the system's frame rate
    faces : opened files of recorded ``points`` at the camera's frame rate
    coding : :class:`visualspeech.face.coding.VisualCoding`
    mouth, names : the lips, and the names of the recorded points
    alignments, speakers : by id, and by name

    Raises
    ------
    StorageError
        An utterance is missing.
    DataError
        As :func:`lip_statistics`.
    """
    mouths = mouth.among(point_names(coding)), mouth.among(names)
    for one in utterances:
        true, rate = faces.array(one.id, "points"), faces.rate(one.id)
        decoded = coding.decode_points(predictions.array(one.id, "appearance"), one.speaker)
        read = at_frames(decoded, predictions.rate(one.id), len(true), rate)
        found = lip_statistics(read, true, mouths, alignments[one.id], rate, speakers[one.speaker])
        yield {"row": row, "id": one.id, "rate": rate, **found}


def lip_table(lines: Iterable[dict]):
    """The table (:class:`pandas.DataFrame`) of lines of :func:`lip_rows` or :func:`cost_rows`, each row's by id."""
    import pandas

    lines = list(lines)
    table = pandas.DataFrame(lines, columns=None if lines else ["row", "id", "frames", "seconds", "parameters"])
    order = {name: number for number, name in enumerate(dict.fromkeys(table["row"]))}
    return table.sort_values(["row", "id"], key=lambda column: column.map(order) if column.name == "row" else column,
                             ignore_index=True)  # fmt: skip


def cost_rows(row: str, utterances: Sequence[Utterance], model, speed) -> Iterator[dict]:
    """What each test utterance's prediction by a model cost: ``row id seconds parameters``.

    Parameters
    ----------
    row : its name
    model, speed : paths of its file, and of the processor seconds of its predictions

    Raises
    ------
    StorageError
        A file is missing or damaged, or an utterance was not timed.
    """
    parameters, seconds = parameter_count(read_model(model)[0]), read_speed(speed)
    for one in utterances:
        if one.id not in seconds:
            raise DamagedFile(speed, f"utterance {one.id} is missing")
        yield {"row": row, "id": one.id, "seconds": seconds[one.id], "parameters": parameters}


def read_lip_tables(path, costs, rows: Sequence[str]) -> list:
    """The lines of each of some rows in a file of :func:`lip_table`, with what they cost, in the order of ``rows``.

    What is no model has cost nothing that could be compared: NaN.

    Parameters
    ----------
    path, costs : files of the lines of :func:`lip_rows` and of those of :func:`cost_rows`

    Raises
    ------
    StorageError
        A file is missing, no such table, or lacks a row.
    """
    table = read_table(path, ("row", "id"), None, ("row", "id", "frames"))
    table = table.merge(
        read_table(costs, ("row", "id"), ("seconds", "parameters"), ("row", "id")), "left", ["row", "id"]
    )
    parts = {str(name): part.drop(columns="row").reset_index(drop=True) for name, part in table.groupby("row")}
    for name in rows:
        if name not in parts:
            raise DamagedFile(path, f"it has no line of {name}")
    return [parts[name] for name in rows]
