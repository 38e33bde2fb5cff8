"""Make the recordings of one shard of the demo corpus; the truth behind them is kept apart."""

from visualspeech.corpora.demo.recording import record_shard
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job
from visualspeech.storage.files import replacing

with job(snakemake.log[0]), replacing(snakemake.output.recordings) as folder:
    folder.mkdir()
    record_shard(read_utterances(snakemake.input[0]), folder, snakemake.output.truth)
