"""Compute the label parts of one shard: position in the syllable and in the word, stress."""

from visualspeech.features.label_parts import label_parts
from visualspeech.jobs import job
from visualspeech.speech import tts
from visualspeech.speech.alignment import read_alignments
from visualspeech.speech.phones import SILENCE
from visualspeech.storage import ArrayReader, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.features) as features,
    ArrayWriter(snakemake.output[0]) as out,
):
    alignments = read_alignments(snakemake.input.alignment)
    spoken = {word.label for alignment in alignments.values() for word in alignment.words}
    stresses = tts.stresses(sorted(spoken - {SILENCE})) if "stress" in snakemake.params.parts else {}
    for one in features.ids:
        frames, rate = features.length(one, "labels"), features.rate(one)
        parts = label_parts(alignments[one], frames, rate, snakemake.params.parts, stresses)
        out.add(one, {"parts": parts}, rate)
