"""Write alignments for people: Praat TextGrid and HTS label files."""

from pathlib import Path

from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments
from visualspeech.speech.export import write_hts_labels, write_textgrid
from visualspeech.storage import replacing

with (
    job(snakemake.log[0]),
    replacing(snakemake.output.textgrid) as grids,
    replacing(snakemake.output.labels) as labels,
):
    grids.mkdir()
    labels.mkdir()
    for path in snakemake.input:
        for utterance_id, alignment in read_alignments(path):
            write_textgrid(Path(grids, f"{utterance_id}.TextGrid"), alignment)
            write_hts_labels(Path(labels, f"{utterance_id}.lab"), alignment)
