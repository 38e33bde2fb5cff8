"""Recorded faces as the measures across systems know them: where the lips are, each speaker's scale and closure.

Taken from the recordings themselves, those of training utterances, and not from any visual coding.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from visualspeech.corpora.records import Utterance
from visualspeech.errors import DamagedFile
from visualspeech.evaluation.articulation import PERCENTILE
from visualspeech.evaluation.scoring import centred
from visualspeech.face.mouth import Mouth, MouthNames
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.closures import least_openings
from visualspeech.storage.tables import read_table, write_table

BILABIAL = "bilabial"  # class of phones, :data:`visualspeech.speech.closures.CLOSURES`
PARTS = tuple(one.name for one in fields(Mouth))
_NUMBERS = ("eye_distance", "closed", "occurrences")


@dataclass(frozen=True)
class TrackedSpeaker:
    """What the measures need to know about a speaker, from his recordings.

    Parameters
    ----------
    speaker : name
    eye_distance : distance of the outer corners of the eyes, in the unit of the points; NaN where they are not recorded
    closed : largest opening that counts as closed, less the mean over the utterance, in the unit of the points; NaN
        without occurrences of p, b, m
    occurrences : number of training occurrences that it was taken from
    """

    speaker: str
    eye_distance: float
    closed: float
    occurrences: int

    @property
    def unit(self) -> float:
        """1 % of the distance of the eyes, in which lengths are measured; the points' own unit where it is unknown."""
        return self.eye_distance / 100 if np.isfinite(self.eye_distance) else 1.0


def tracked_speaker(
    speaker: str, eye_distance: float, recorded: Iterable[tuple[np.ndarray, Alignment, float]]
) -> TrackedSpeaker:
    """A speaker whose threshold of closure is the 90th percentile of the recorded least openings in p, b and m.

    Parameters
    ----------
    recorded : opening (T,), alignment and frame rate in Hz of each training utterance
    """
    found = [least_openings(centred(opening), *spoken, BILABIAL) for opening, *spoken in recorded]
    values = np.concatenate(found) if found else np.zeros(0)
    threshold = float(np.percentile(values, PERCENTILE)) if len(values) else float("nan")
    return TrackedSpeaker(speaker, float(eye_distance), threshold, len(values))


def write_speakers(path, speakers: Iterable[TrackedSpeaker]) -> None:
    """Write tracked speakers as a table, a row for each."""
    import pandas

    columns = ["speaker", *_NUMBERS]
    write_table(path, pandas.DataFrame([vars(one) for one in speakers], columns=columns))


def read_speakers(path) -> dict[str, TrackedSpeaker]:
    """What :func:`write_speakers` wrote, by name.

    Raises
    ------
    StorageError
        The file is missing, or not such a table.
    """
    table = read_table(path, ("speaker",), _NUMBERS, ("speaker",))
    found = {
        one.speaker: TrackedSpeaker(one.speaker, float(one.eye_distance), float(one.closed), int(one.occurrences))
        for one in table.itertuples(index=False)
    }
    if len(found) != len(table):
        raise DamagedFile(path, "a speaker has several rows")
    return found


def tracked_speakers(
    utterances: Iterable[Utterance],
    faces,
    mouth: Mouth | None,
    alignments: Mapping[str, Alignment],
    eye_distances: Mapping[str, float],
) -> list[TrackedSpeaker]:
    """What the measures need to know of each speaker, in the order of ``eye_distances``.

    Parameters
    ----------
    utterances : training utterances
    faces : opened files of recorded ``points``
    mouth : the lips among them; None where closed lips cannot be told
    alignments : of these utterances, by id
    eye_distances : of all speakers by name, in the unit of the points; NaN where unknown
    """
    own: dict[str, list[str]] = {speaker: [] for speaker in eye_distances}
    for one in utterances if mouth else ():
        own[one.speaker].append(one.id)
    return [
        tracked_speaker(
            speaker,
            eye_distances[speaker],
            ((mouth.opening(faces.array(one, "points")), alignments[one], faces.rate(one)) for one in ids),
        )
        for speaker, ids in own.items()
    ]


def mean_face(ids: Sequence[str], faces) -> np.ndarray:
    """Mean over all frames of the recorded points (P, d) of some utterances, in opened files."""
    total, count = 0.0, 0
    for one in ids:
        points = faces.array(one, "points").astype(np.float64)
        total, count = total + points.sum(axis=0), count + len(points)
    return total / count


def write_mouth(path, mouth: MouthNames) -> None:
    """Write the names of the lip points as a table, a row for each part of the mouth and point."""
    import pandas

    rows = [(part, name) for part in PARTS for name in getattr(mouth, part)]
    write_table(path, pandas.DataFrame(rows, columns=["part", "point"]))


def read_mouth(path) -> MouthNames:
    """What :func:`write_mouth` wrote; raises as :func:`read_table`, or where a part is unknown."""
    table = read_table(path, ("part", "point"), required=("part", "point"))
    if not set(table["part"]) <= set(PARTS):
        raise DamagedFile(path, f"a part of the mouth is none of {', '.join(PARTS)}")
    return MouthNames(**{part: tuple(table["point"][table["part"] == part]) for part in PARTS})
