"""Make the recordings of one shard of the demo corpus; the truth behind them is kept apart."""

from pathlib import Path

from visualspeech.corpora.demo.record import record_shard
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job
from visualspeech.storage import replacing

with job(snakemake.log[0]), replacing(snakemake.output.recordings) as folder:
    folder.mkdir()
    utterances = read_utterances(snakemake.input[0])
    record_shard(utterances, folder, Path(snakemake.output.truth), snakemake.params.corpus)
