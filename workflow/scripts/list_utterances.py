"""Write the utterances of one shard, as the plan lists them."""

from visualspeech.corpora.table import write_utterances
from visualspeech.jobs import job

with job(snakemake.log[0]):
    write_utterances(snakemake.output[0], snakemake.params.rows)
