"""Fit one input block to the training utterances of a corpus."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.blocks.base import Sources, fit_block, load_block, save_block
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
    block = fit_block(
        params.kind,
        params.settings,
        phones,
        Sources(source.alignment, targets, training, sound if source.audio else None, params.faces),
        {name: load_block(path) for name, path in zip(params.made_of, source.blocks, strict=True)},
    )
    save_block(snakemake.output[0], block)
