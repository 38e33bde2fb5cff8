"""Pairs of videos for a preference test, in random order, with the key apart from them."""

from pathlib import Path

from visualspeech.animation.pairs import write_pair
from visualspeech.animation.video import Recording, Speaker
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.preference import answer_sheet, draw_pairs, key_table
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import replacing
from visualspeech.storage.tables import write_table

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    replacing(snakemake.output.videos) as folder,
    ArrayReader(source.first) as first,
    ArrayReader(source.second) as second,
    ArrayCollection(source.landmarks) as landmarks,
    ArrayCollection(source.pose) as pose,
    ArrayCollection(source.textures) as textures,
):
    folder.mkdir()
    speaker, settings = Speaker.load(source.head, source.aam, source.reference), VideoSettings(label=params.label)
    predictions = dict(zip(params.models, (first, second), strict=True))
    utterances = {one.id: one for one in of_split(read_utterances(source.utterances), "test")}
    pairs = draw_pairs(list(utterances), params.models, params.pairs, params.seed)
    for pair in progress(pairs, len(pairs), "pairs"):
        name, path = pair.utterance, Path(folder, f"{pair.number:02d}.mp4")
        recording = Recording.read(landmarks, pose, textures, name)
        sides = [predictions[model] for model in (pair.left, pair.right)]
        streams = [(arrays.array(name, "appearance"), arrays.rate(name)) for arrays in sides]
        write_pair(path, pair.number, utterances[name], recording, streams, speaker, **params.names, settings=settings)
    write_table(snakemake.output.key, key_table(pairs))
    write_table(snakemake.output.sheet, answer_sheet(pairs))
