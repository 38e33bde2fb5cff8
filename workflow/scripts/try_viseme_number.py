"""Reconstruct the validation utterances from their dynamic visemes, with one number of classes."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.viseme_numbers import reconstruction_frame
from visualspeech.features.blocks.base import Sources
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.tables import write_table

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]), ArrayCollection(source.targets) as targets:
    utterances = read_utterances(source.utterances)
    training, validation = (
        Sources([], targets, {one.id for one in of_split(utterances, split)}, faces=True)
        for split in ("train", "validation")
    )
    settings = {**params.settings, "classes": int(snakemake.wildcards.classes)}
    write_table(snakemake.output[0], reconstruction_frame(settings, training, validation))
