"""How well dynamic visemes reconstruct the face, by their number."""

import pandas

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.viseme_numbers import numbers_table
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage.files import write_text
from visualspeech.storage.tables import read_table

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    frame = pandas.concat([read_table(path, ("id",)) for path in source.numbers], ignore_index=True)
    facts = {**params.facts, "split": split_hash(read_split(source.utterances))}
    table = numbers_table(frame, facts, params.digits)
    for path, text in zip(snakemake.output, all_forms(frame, [table], "Number of visemes"), strict=True):
        write_text(path, text)
