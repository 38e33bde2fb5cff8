"""Measure the lips that the rows of a system predict against the recorded ones, at the frames of the camera."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.lip_rows import cost_rows, lip_rows, lip_table
from visualspeech.evaluation.tracked import read_mouth, read_speakers
from visualspeech.face.coding_files import load_coding
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source, params, lines = snakemake.input, snakemake.params, []
with job(snakemake.log[0]), ArrayCollection(source.faces) as faces:
    coding, mouth, speakers = load_coding(source.coding), read_mouth(source.mouth), read_speakers(source.speakers)
    tests = of_split(read_utterances(source.utterances), "test")
    aligned = alignments_of(source.alignment, [one.id for one in tests])
    for name, path in zip(params.rows, source.predictions, strict=True):
        with ArrayReader(path) as predictions:
            lines += lip_rows(name, tests, predictions, faces, coding, mouth, params.names, aligned, speakers)
    write_table(snakemake.output.lips, lip_table(lines))
    models = zip(params.models, source.models, source.speed, strict=True)
    costs = [line for name, *paths in models for line in cost_rows(name, tests, *paths)]
    write_table(snakemake.output.costs, lip_table(costs))
