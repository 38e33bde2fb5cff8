"""The folder of clips of a system whose visual coding are markers: test utterances, each with its controls."""

from collections.abc import Iterable, Mapping
from itertools import zip_longest
from pathlib import Path

import numpy as np

from visualspeech.animation.markers.actor import Actor, fit_actor, loudness
from visualspeech.animation.markers.clips import Motion, marker_metadata, write_clip, write_controls
from visualspeech.animation.markers.layouts import layout_of
from visualspeech.corpora.records import Utterance
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.storage.arrays import ArrayCollection, ArrayReader

MAX_RECORDINGS = 200  # of a speaker, from which the range of motion is taken
ANYBODY = ""  # key of the actor of a speaker without training utterances


def chosen_clips(utterances: Iterable[Utterance], count: int) -> list[Utterance]:
    """Some utterances, taken in turn from each speaker and emotion, so that a few clips show as many as they can."""
    groups: dict[tuple[str, str], list[Utterance]] = {}
    for one in utterances:
        groups.setdefault((one.speaker, one.emotion), []).append(one)
    rounds = zip_longest(*(groups[key] for key in sorted(groups)))
    return [one for turn in rounds for one in turn if one is not None][:count]


def motion_of(coding: MarkerCoding, arrays: ArrayReader | ArrayCollection, utterance: Utterance) -> Motion:
    """Decoded points of an utterance from a file of parameters or predictions."""
    parameters = arrays.array(utterance.id, "appearance")
    return Motion(coding.decode_points(parameters, utterance.speaker), arrays.rate(utterance.id))


def actors_of(
    coding: MarkerCoding, training: Iterable[Utterance], parameters: ArrayCollection, audio: ArrayCollection
) -> dict[str, Actor]:
    """Actor of each speaker, and :data:`ANYBODY` of all together, by training utterances; empty without a layout.

    Parameters
    ----------
    parameters : recorded faces in the coding
    audio : ``samples`` of the utterances, by which the idle face is found
    """
    layout = layout_of(coding.markers.names, coding.dimensions)
    if layout is None:
        return {}
    recorded: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for one in training:
        own = recorded.setdefault(one.speaker, [])
        if len(own) < MAX_RECORDINGS and one.id in parameters and one.id in audio:
            motion = motion_of(coding, parameters, one)
            samples = audio.array(one.id, "samples")
            own.append((motion.points, loudness(samples, audio.rate(one.id), len(motion.points), motion.rate)))
    recorded[ANYBODY] = [pair for own in recorded.values() for pair in own]
    return {
        speaker: fit_actor(layout, coding.markers.names, *map(np.concatenate, zip(*own, strict=True)))
        for speaker, own in recorded.items()
        if own
    }


def write_files(
    folder: str | Path,
    utterance: Utterance,
    coding: MarkerCoding,
    parameters: ArrayCollection,
    predictions: ArrayReader,
    audio: ArrayCollection,
    actors: Mapping[str, Actor],
    names: Mapping[str, str],
    label: bool = True,
) -> None:
    """Write the clip of an utterance, ``<id>.mp4``, and the controls of its prediction, ``<id>.fap`` and ``<id>.csv``.

    Parameters
    ----------
    names : ``corpus``, ``model`` and ``consent``, for the metadata

    Raises
    ------
    DataError
        Streams of this utterance do not fit each other.
    StorageError
        A file cannot be read or written.
    """
    predicted = motion_of(coding, predictions, utterance)
    samples = audio.array(utterance.id, "samples").astype(np.float32) / 32768
    write_clip(
        Path(folder, f"{utterance.id}.mp4"),
        utterance,
        coding.markers.names,
        motion_of(coding, parameters, utterance),
        predicted,
        samples,
        round(audio.rate(utterance.id)),
        marker_metadata(utterance.id, **names),
        label,
    )
    actor = actors.get(utterance.speaker) or actors.get(ANYBODY)
    if actor:
        write_controls(folder, utterance, predicted, actor)
