"""The openings of the lips that count as closed and as open, by the recorded training utterances."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.articulation import targets_of, write_targets
from visualspeech.face.coding_files import load_coding
from visualspeech.face.lips import has_inner_lips, lip_opening
from visualspeech.face.point_sets import to_points
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection

source = snakemake.input
with job(snakemake.log[0]), ArrayCollection(source.targets) as targets:
    points = load_coding(source.coding).points
    names = [one.id for one in of_split(read_utterances(source.utterances), "train")]
    aligned = alignments_of(source.alignment, names) if has_inner_lips(points) else {}
    recorded = (
        (lip_opening(to_points(targets.array(name, "points")), points), alignment, targets.rate(name))
        for name, alignment in aligned.items()
    )
    write_targets(snakemake.output[0], targets_of(recorded))
