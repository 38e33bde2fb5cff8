"""What is fitted and judged per speaker: the head, and which of the speaker's utterances stand out.

A speaker is named by the id that files carry (:func:`visualspeech.corpora.records.legal_id` of the corpus's name). One
head, one camera and one frame size are assumed per speaker.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from visualspeech.errors import CorpusError, RejectedUtterance
from visualspeech.face.head import HeadModel, PoseSettings, fit_head
from visualspeech.face.pose import rigid_error
from visualspeech.face.sampling import sample_landmarks, screen_frame_sizes
from visualspeech.face.screening import ScreeningSettings, screen_rigid_errors


def fit_speaker_head(speaker: str, landmarks, ids: Sequence[str], settings: PoseSettings | None = None) -> HeadModel:
    """Fit the head of one speaker to frames spread evenly over training utterances.

    Parameters
    ----------
    speaker : for messages
    landmarks : opened landmark files that hold these utterances
    ids : the speaker's training utterances

    Raises
    ------
    CorpusError
        There are no utterances.
    DataError
        As :func:`visualspeech.face.head.fit_head`.
    """
    if not ids:
        raise CorpusError(
            f"no training utterance of the speaker {speaker!r} has a tracked face. See the findings of the check and "
            "of the landmarks; leave this speaker out, or record the speaker again."
        )
    settings = settings or PoseSettings()
    points, size = sample_landmarks(landmarks, ids, settings.frames)
    return fit_head(points, size, settings)


def load_heads(speakers: Sequence[str], paths: Sequence[str | Path]) -> dict[str, HeadModel]:
    """The heads of some speakers by the speaker's name, from one file per speaker, in the same order.

    Raises
    ------
    StorageError
        A file is missing or holds no head.
    """
    return {speaker: HeadModel.load(path) for speaker, path in zip(speakers, paths, strict=True)}


def screen_speakers(
    landmarks,
    pose,
    heads: Mapping[str, HeadModel],
    speakers: Mapping[str, str],
    settings: ScreeningSettings | None = None,
) -> dict[str, RejectedUtterance]:
    """Utterances that stand out among those of their speaker: by frame size, or by rigid points that move.

    Parameters
    ----------
    landmarks, pose : opened files of all utterances
    heads : of each speaker
    speakers : utterance id -> speaker
    """
    refused: dict[str, RejectedUtterance] = {}
    for speaker in sorted({speakers[one] for one in pose.ids}):
        ids = [one for one in pose.ids if speakers[one] == speaker]
        errors = {one: rigid_error(pose.array(one, "points"), heads[speaker]) for one in ids}
        refused |= screen_rigid_errors(errors, settings) | screen_frame_sizes(landmarks, ids)
    return refused
