"""Which utterances stand out among those of their speaker: one head and one frame size are assumed per speaker."""

from collections.abc import Mapping

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
