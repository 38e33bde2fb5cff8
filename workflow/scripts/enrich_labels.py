"""What the labels of one shard say beyond phones and states."""

from visualspeech.features.richer import SILENCE, label_parts
from visualspeech.jobs import job
from visualspeech.speech import tts
from visualspeech.speech.rows import read_alignment_rows
from visualspeech.storage import ArrayReader, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.features) as features,
    ArrayWriter(snakemake.output[0]) as out,
):
    alignments = read_alignment_rows(snakemake.input.alignment)
    spoken = {word for rows in alignments.values() for word in rows.loc[rows["tier"] == "word", "label"]}
    stresses = tts.stresses(sorted(spoken - {SILENCE})) if "stress" in snakemake.params.parts else {}
    for one in features.ids:
        frames, rate = features.length(one, "labels"), features.rate(one)
        parts = label_parts(alignments[one], frames, rate, snakemake.params.parts, stresses)
        out.add(one, {"parts": parts}, rate)
