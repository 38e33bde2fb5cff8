"""Collect what speaking needs of a run into one folder: models, the face at rest, and recorded frames."""

from visualspeech.animation.bundling import RecordedFaces, bundle_speaker
from visualspeech.corpora.table import read_utterances
from visualspeech.features.contexts import read_phones
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayCollection(source.landmarks) as landmarks,
    ArrayCollection(source.pose) as pose,
    ArrayCollection(source.textures) as textures,
    ArrayCollection(source.parameters) as parameters,
):
    bundle_speaker(
        snakemake.output[0],
        {name: source[name] for name in ("model", "aam", "reference", "head", "sound") if source[name]},
        read_phones(source.phones),
        read_utterances(source.utterances),
        source.alignment,
        RecordedFaces(landmarks, pose, textures, parameters),
        params.background,
        seconds=params.seconds,
        model=snakemake.wildcards.model,
        sound_model=params.sound_model,
        dictionary=params.dictionary,
        **params.names,
    )
