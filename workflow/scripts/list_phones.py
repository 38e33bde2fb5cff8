"""The phones that the corpus speaks: the K of the label vectors."""

import pandas

from visualspeech.features.labels import phone_inventory
from visualspeech.jobs import job
from visualspeech.speech.rows import read_alignment_table
from visualspeech.storage import write_table

with job(snakemake.log[0]):
    phones = phone_inventory(read_alignment_table(path) for path in snakemake.input)
    write_table(snakemake.output[0], pandas.DataFrame({"phone": phones}))
