"""List the phones of the corpus: the K of the label vectors."""

import pandas

from visualspeech.features.contexts import phone_inventory
from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments
from visualspeech.storage import write_table

with job(snakemake.log[0]):
    phones = phone_inventory(alignment for path in snakemake.input for alignment in read_alignments(path).values())
    write_table(snakemake.output[0], pandas.DataFrame({"phone": phones}))
