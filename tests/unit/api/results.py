"""A small results folder with one system, for tests of what reads a finished run."""

from pathlib import Path

import numpy as np

from tests.unit.face.aam.faces import POINTS, moving_faces
from tests.unit.speech.alignments import even_alignment
from visualspeech.api.faces import fit_aam
from visualspeech.corpora.findings import write_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import write_accepted
from visualspeech.evaluation.regions import region_statistics
from visualspeech.evaluation.scoring import score_table
from visualspeech.face.aam.model_settings import AamSettings
from visualspeech.models.mean import TrainingMean
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import to_table
from visualspeech.storage.arrays import ArrayWriter
from visualspeech.storage.files import write_text
from visualspeech.storage.tables import write_table

SPLIT = {"a1": "train", "a2": "train", "b1": "validation", "c1": "test", "c2": "test"}
RATE, FRAMES = 25.0, 20
MODELS = ("first", "second")


def make(folder: Path, seed: int = 0) -> Path:
    """Write it; the second shard holds the test utterances."""
    rng = np.random.default_rng(seed)
    utterances = [Utterance(name, "ann", f"{name}.mp4", 'Hello, "all"!') for name in SPLIT]
    write_accepted(folder / "utterances.tsv", utterances, SPLIT)
    write_findings(folder / "findings.tsv", [])
    (folder / "corpus").mkdir()
    aam = fit_aam(
        POINTS.select(moving_faces(40)), rng.integers(0, 255, size=(40, 60)),
        settings=AamSettings(shape={"components": 3}, texture={"components": 3}, appearance={"components": 4}),
    )  # fmt: skip
    coding = folder / "codings" / "aam51"
    aam.save(coding / "model.safetensors")
    write_accepted(coding / "utterances.tsv", utterances, SPLIT)
    system, shards = folder / "fan2015", {0: ["a1", "a2", "b1"], 1: ["c1", "c2"]}
    for shard, names in shards.items():
        said = {name: even_alignment([("sil", ["sil"]), ("bee", ["b", "iy"]), ("sil", ["sil"])], 0.2) for name in names}
        write_table(folder / "alignment" / f"{shard}.tsv", to_table(said))
        with ArrayWriter(system / "targets" / f"{shard}.h5") as out:
            for name in names:
                out.add(name, {"appearance": rng.normal(size=(FRAMES, 4)).astype(np.float32)}, RATE)
    for model in MODELS:
        own, rows = system / "models" / model, []
        with ArrayWriter(own / "predictions.h5") as out:
            for name in ("b1", "c1", "c2"):
                predicted = rng.normal(size=(FRAMES, 4)).astype(np.float32)
                out.add(name, {"appearance": predicted}, RATE)
                rows.append(region_statistics(name, predicted, predicted + 1, RATE, {"lower": [0, 1]}))
        write_table(own / "statistics.tsv", score_table(rows))
        TrainingMean(np.zeros(4), RATE, file_digest(coding / "model.safetensors")).save(own / "model.safetensors")
    write_text(system / "tables" / "objective.tsv", "# corpus: made\n# rate: 25 Hz\nrow\tcorr\nfirst\t0.5\n")
    return folder
