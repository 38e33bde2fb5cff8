"""The report: one page that opens offline."""

from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.evaluation import gathering
from visualspeech.evaluation.report import ReportContent, render_report
from visualspeech.evaluation.sheets import fragment_of
from visualspeech.evaluation.table_formats import from_tsv
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage import ArrayCollection, read_text, write_text

source, settings = snakemake.input, snakemake.params.settings
with job(snakemake.log[0]), ArrayCollection(source.features) as features:
    utterances, model = read_utterances(source.utterances), settings["videos"]["model"]
    sizes, frames = gathering.split_sizes(utterances, features)
    content = ReportContent(
        corpus=settings["corpus"]["name"],
        experiment=settings["experiment"],
        split_hash=split_hash(read_split(source.utterances)),
        drift=settings["drift"]["method"],
        consent=settings["corpus"].get("consent", ""),
        utterances=sizes,
        frames=frames,
        tables=(from_tsv(read_text(source.table)),),
        sheets=tuple(fragment_of(read_text(path)) for path in source.sheets),
        learning_curves=gathering.learning_curves(source.curves),
        trajectories=gathering.trajectory_pictures(utterances, features, source.predictions, source.alignment, 3),
        modes=gathering.aam_modes(Aam.load(source.aam), Reference.load(source.reference)),
        videos=gathering.videos(source.videos, snakemake.output[0], utterances, model),
        findings=gathering.findings(source.findings),
        timings=gathering.stage_timings(snakemake.params.benchmarks, frames),
        settings=settings,
        versions=gathering.versions(),
    )
    write_text(snakemake.output[0], render_report(content))
