"""The phones that the corpus speaks: the K of the label vectors."""

from visualspeech.features.contexts import phone_inventory, write_phones
from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments

with job(snakemake.log[0]):
    alignments = (alignment for path in snakemake.input for alignment in read_alignments(path).values())
    write_phones(snakemake.output[0], phone_inventory(alignments))
