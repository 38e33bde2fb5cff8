"""Train one model; a killed training resumes from its checkpoint with the same result."""

from importlib import import_module
from pathlib import Path

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.examples import Examples, opened_blocks
from visualspeech.jobs import job
from visualspeech.models.block_states import load_blocks
from visualspeech.models.lips import recorded_lips
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task
from visualspeech.provenance import file_digest
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.regions import coding_regions
from visualspeech.storage.tables import write_table

source, row = snakemake.input, ModelRow.of(snakemake.params.row)
with (
    job(snakemake.log[0]),
    opened_blocks(source.features, len(row.reads)) as features,
    ArrayCollection(source.targets) as targets,
):
    utterances = read_utterances(source.utterances)
    training, validation = (
        Examples(features, targets, [one.id for one in of_split(utterances, split)])
        for split in ("train", "validation")
    )
    # Not an output: it must outlive a killed job, whose outputs are removed before it runs again.
    checkpoint = Path(snakemake.output.model).with_name("checkpoint.safetensors")
    parents = [Path(path) for path in source.parents]
    blocks = load_blocks(dict(zip(row.reads, source.blocks, strict=True)))
    lips = recorded_lips(row, training.ids, targets, source.alignment)
    regions = coding_regions(source.coding)
    task = Task(row, blocks, training, validation, file_digest(source.coding), parents, checkpoint, lips, regions)
    fitted = import_module(snakemake.params.module).fit(task)
    write_table(snakemake.output.curve, fitted.curve)
    fitted.model.save(snakemake.output.model)
    for kept in checkpoint.parent.glob(f"{checkpoint.stem}*{checkpoint.suffix}"):
        kept.unlink()
