"""The streams of one input block for one shard."""

from visualspeech.corpora.table import read_utterances
from visualspeech.features.blocks.base import encoding_needs, load_block, phones_of, read_sources
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayReader, ArrayWriter

source = snakemake.input
with (
    job(snakemake.log[0]),
    ArrayReader(source.targets) as targets,
    ArrayCollection(source.audio) as sound,
    ArrayWriter(snakemake.output[0]) as out,
):
    block = load_block(source.block)
    alignment, audio = next(iter(source.alignment), None), sound if source.audio else None
    faces = "faces" in encoding_needs(block)
    speakers = {one.id: one.speaker for one in read_utterances(source.utterances)}
    sources = read_sources(alignment, targets, targets.ids, phones_of(block), True, audio, faces, speakers)
    for name, stream in zip(sources, block.encode(list(sources.values())), strict=True):
        out.add(name, stream.arrays(), targets.rate(name))
