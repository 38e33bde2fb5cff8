"""The phones that the training utterances speak: the K of the label vectors."""

from itertools import chain

from visualspeech.corpora.table import read_split
from visualspeech.features.contexts import phone_inventory, write_phones
from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments

with job(snakemake.log[0]):
    split = read_split(snakemake.input.split)
    aligned = chain.from_iterable(read_alignments(path).items() for path in snakemake.input.alignment)
    training = (alignment for name, alignment in aligned if split[name] == "train")
    write_phones(snakemake.output[0], phone_inventory(training))
