"""Write alignments for people and other programs: Praat TextGrid beside its sound, HTK and HTS label files."""

from pathlib import Path

import soundfile

from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments
from visualspeech.speech.export import write_htk_labels, write_hts_labels, write_textgrid
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.files import replacing

with (
    job(snakemake.log[0]),
    replacing(snakemake.output.textgrid) as grids,
    replacing(snakemake.output.htk) as htk,
    replacing(snakemake.output.hts) as hts,
):
    for folder in (grids, htk, hts):
        folder.mkdir()
    for table, sound in zip(snakemake.input.tables, snakemake.input.audio, strict=True):
        with ArrayReader(sound) as audio:
            for one, alignment in read_alignments(table).items():
                soundfile.write(Path(grids, f"{one}.wav"), audio.array(one, "samples"), int(audio.rate(one)))
                write_textgrid(Path(grids, f"{one}.TextGrid"), alignment)
                write_htk_labels(Path(htk, f"{one}.lab"), alignment)
                write_hts_labels(Path(hts, f"{one}.lab"), alignment)
