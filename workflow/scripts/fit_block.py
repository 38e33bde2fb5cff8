"""Fit one input block to the training utterances of a corpus."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.blocks.base import block_class, read_sources, save_block
from visualspeech.features.contexts import read_phones
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayCollection(source.targets) as targets,
    ArrayCollection(source.audio) as sound,
):
    training = {one.id for one in of_split(read_utterances(source.utterances), "train")}
    phones = read_phones(source.phones[0]) if source.phones else ()
    audio = sound if source.audio else None
    block = block_class(params.kind).fit(
        params.settings,
        phones,
        # Without an alignment, one pass over all shards.
        (
            one
            for path in source.alignment or [None]
            for one in read_sources(path, targets, training, audio=audio).values()
        ),
    )
    save_block(snakemake.output[0], block)
