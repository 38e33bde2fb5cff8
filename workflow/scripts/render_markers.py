"""Clips of test utterances as points and lines, recorded beside predicted, and controls for other animation systems."""

from visualspeech.animation.markers.rendering import actors_of, chosen_clips, write_files
from visualspeech.corpora.findings import attempt
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.jobs import job, log, progress
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import replacing

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    replacing(snakemake.output[0]) as folder,
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.parameters) as parameters,
    ArrayCollection(source.audio) as audio,
):
    folder.mkdir()
    if not params.names["consent"]:
        log.warning("the corpus does not say whose face it holds and by what permission; add `consent:` to its file")
    coding, utterances = MarkerCoding.load(source.coding), read_utterances(source.utterances)
    actors = actors_of(coding, of_split(utterances, "train"), parameters, audio)
    if not actors:
        log.info("no .fap and .csv files: the map to controls knows other markers than those of %s", coding.source)
    chosen = chosen_clips(of_split(utterances, "test"), params.clips)
    files = (coding, parameters, predictions, audio, actors, params.names, params.label)
    for one in progress(chosen, len(chosen), "videos"):
        for finding in attempt(one, "videos", write_files, folder, one, *files).findings:
            log.warning("no video of %s (%s): %s. %s", one.id, finding.file, finding.finding, finding.remedy)
