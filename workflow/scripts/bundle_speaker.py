"""Gather what speaking needs of a run into one folder: models, the face at rest, and recorded pictures."""

import shutil

from visualspeech.animation.background import choose_recordings, write_background
from visualspeech.animation.bundle import FILES, describe_bundle, resting_face
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.errors import SettingError
from visualspeech.face.drift import reference_face
from visualspeech.face.pose import Pose
from visualspeech.features.contexts import read_phones
from visualspeech.jobs import job, log
from visualspeech.media.reading import read_frames
from visualspeech.speech.alignment import read_alignments
from visualspeech.speech.spoken import state_shares
from visualspeech.storage import ArrayCollection, replacing

source, names, wanted = snakemake.input, snakemake.params.names, list(snakemake.params.background)
with (
    job(snakemake.log[0]),
    replacing(snakemake.output[0]) as folder,
    ArrayCollection(source.landmarks) as landmarks,
    ArrayCollection(source.pose) as pose,
    ArrayCollection(source.textures) as textures,
    ArrayCollection(source.parameters) as parameters,
):
    folder.mkdir()
    for name in ("network", "aam", "reference", "head"):
        shutil.copyfile(source[name], folder / FILES[name])
    utterances = {one.id: one for one in read_utterances(source.utterances)}
    training = of_split(utterances.values(), "train")
    missing = [name for name in wanted if name not in utterances]
    if missing:
        raise SettingError(f"`speak.background`: {', '.join(missing)} is not among the ids of {source.utterances}.")
    if not wanted:
        rate = pose.rate(training[0].id)
        faces = ((one.id, landmarks.array(one.id, "points"), reference_face(textures, one.id)) for one in training)
        wanted = choose_recordings(faces, snakemake.params.seconds, rate)
    log.info("background: %s", ", ".join(wanted))
    clips = (
        (
            one.id, one.media, read_frames(one.media, one.start, one.end), landmarks.array(one.id, "points"),
            Pose(pose.array(one.id, "rotation"), pose.array(one.id, "translation")),
            reference_face(textures, one.id), pose.rate(one.id),
        )
        for one in (utterances[name] for name in wanted)
    )  # fmt: skip
    write_background(folder / FILES["background"], clips)
    ids = {one.id for one in training}
    aligned = {name: found for path in source.alignment for name, found in read_alignments(path, ids).items()}
    rest = resting_face(
        lambda: (
            (found, parameters.array(name, "appearance"), parameters.rate(name)) for name, found in aligned.items()
        )
    )
    shares, phones = state_shares(aligned.values()), read_phones(source.phones)
    describe_bundle(folder, phones, shares, rest, model=snakemake.wildcards.model, **names)
