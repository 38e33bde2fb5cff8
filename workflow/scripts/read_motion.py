"""Read the motion capture of one shard onto a regular grid, without gaps."""

from visualspeech.corpora.findings import WARN, Finding, attempt, write_findings
from visualspeech.corpora.motion import STAGE, UNITS, MotionSource, read_motion
from visualspeech.corpora.motion_settings import MotionSettings
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.audio) as audio,
    ArrayWriter(snakemake.output.motion) as out,
):
    source = MotionSource(**snakemake.params.source)
    settings, findings = MotionSettings(**snakemake.params.settings), []
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    for one in progress(utterances, len(utterances), "utterances"):
        seconds = audio.length(one.id, "samples") / audio.rate(one.id)
        found = attempt(one, STAGE, read_motion, one, source, seconds, settings)
        findings += found.findings
        if found.rejected is None:
            motion = found.value
            out.add(one.id, {"points": motion.points}, motion.rate, {"points": UNITS.get(source.format, "as recorded")})
            findings += [Finding(one.id, STAGE, WARN, one.file, note, "") for note in motion.notes]
    write_findings(snakemake.output.findings, findings)
