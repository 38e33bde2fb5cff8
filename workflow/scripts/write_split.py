"""Write which utterances models are trained, validated and tested on."""

from visualspeech.corpora.table import write_split
from visualspeech.jobs import job

with job(snakemake.log[0]):
    write_split(snakemake.output[0], snakemake.params.split)
