"""Decide which utterances the models see: those that no stage has rejected."""

from visualspeech.corpora.findings import check_share, read_findings, rejected_ids, rejection, write_findings
from visualspeech.corpora.motion import screen_dimensions
from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import read_split, read_utterances, write_accepted
from visualspeech.face.head import load_heads
from visualspeech.face.screening import ScreeningSettings
from visualspeech.face.speakers import screen_speakers
from visualspeech.jobs import job, log
from visualspeech.storage.arrays import ArrayCollection

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.landmarks) as landmarks,
    ArrayCollection(snakemake.input.pose or snakemake.input.motion) as faces,
):
    utterances = {one.id: one for path in snakemake.input.utterances for one in read_utterances(path)}
    speakers = {name: legal_id(one.speaker) for name, one in utterances.items()}
    heads = load_heads(snakemake.params.speakers, snakemake.input.heads)
    settings = ScreeningSettings(**snakemake.params.settings)
    split = read_split(snakemake.input.split)
    training = {name for name, part in split.items() if part == "train"}
    if snakemake.input.pose:
        refused = screen_speakers(landmarks, faces, heads, speakers, training, settings)
    else:
        refused = screen_dimensions(faces, faces.ids)
    findings = read_findings(*snakemake.input.findings)
    findings += [
        rejection(one, "pose" if snakemake.input.pose else "motion", utterances[one].file, error)
        for one, error in refused.items()
    ]
    check_share(findings, len(utterances), snakemake.params.limit)
    rejected = rejected_ids(findings)
    accepted = [one for one in utterances.values() if one.id in faces and one.id not in rejected]
    log.info("%d of %d utterances accepted", len(accepted), len(utterances))
    write_accepted(snakemake.output.accepted, accepted, split)
    write_findings(snakemake.output.findings, findings)
