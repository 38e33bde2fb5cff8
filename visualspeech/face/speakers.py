"""Rejection of utterances that differ from the others of their speaker in frame size or head."""

from collections.abc import Collection, Mapping

from visualspeech.errors import RejectedUtterance
from visualspeech.face.head import HeadModel
from visualspeech.face.pose import rigid_error
from visualspeech.face.sampling import screen_frame_sizes
from visualspeech.face.screening import ScreeningSettings, screen_rigid_errors


def screen_speakers(
    landmarks,
    pose,
    heads: Mapping[str, HeadModel],
    speakers: Mapping[str, str],
    training: Collection[str],
    settings: ScreeningSettings | None = None,
) -> dict[str, RejectedUtterance]:
    """Rejections of utterances that differ from the others of their speaker, by utterance id.

    One head and one frame size are assumed per speaker, so utterances are rejected that have another frame size or
    whose rigid points move after pose normalisation. What is usual is taken from the training utterances.

    Parameters
    ----------
    landmarks, pose : opened files of all utterances
    heads : speaker -> head model
    speakers : utterance id -> speaker
    training : the training utterances
    """
    rejected: dict[str, RejectedUtterance] = {}
    for speaker in sorted({speakers[one] for one in pose.ids}):
        ids = [one for one in pose.ids if speakers[one] == speaker]
        errors = {one: rigid_error(pose.array(one, "points"), heads[speaker]) for one in ids}
        rejected |= screen_rigid_errors(errors, training, settings)
        rejected |= screen_frame_sizes(landmarks, ids, [one for one in ids if one in training])
    return rejected
