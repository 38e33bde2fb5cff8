"""Fit one input block to the training utterances of a corpus."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.blocks.base import Sources, fit_block, load_block, save_block, with_unseen_speakers
from visualspeech.features.contexts import read_phones
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayCollection(source.targets) as targets,
    ArrayCollection(source.audio) as sound,
):
    utterances = read_utterances(source.utterances)
    training = of_split(utterances, "train")
    seen, speakers = {one.speaker for one in training}, {one.id: one.speaker for one in utterances}
    unseen = {one.id for one in utterances if one.speaker not in seen}
    audio = sound if source.audio else None
    trained, others = (
        Sources(source.alignment, targets, ids, audio, params.faces, speakers)
        for ids in ({one.id for one in training}, unseen)
    )
    phones = read_phones(source.phones[0]) if source.phones else ()
    parts = {name: load_block(path) for name, path in zip(params.made_of, source.blocks, strict=True)}
    block = fit_block(params.kind, params.settings, phones, trained, parts)
    if unseen:
        block = with_unseen_speakers(block, others)
    save_block(snakemake.output[0], block)
