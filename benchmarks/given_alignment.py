"""How an alignment survives the way through TextGrid files, and where their states lie.

Run: python -m benchmarks.given_alignment RESULTS

RESULTS is the folder of a corpus's results after the target `alignment` with forced alignment, for example
results/demo. Reads its exported TextGrids with each kind of `states` and compares with its tables. Prints the number of
utterances whose words and phones are equal, of those whose states are too, and the distance of the ends of states: mean
and 99th percentile.
"""

from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from visualspeech.corpora.aligning import AlignmentSources, aligner
from visualspeech.corpora.label_files import find_label_files
from visualspeech.corpora.records import Utterance
from visualspeech.speech.alignment import read_alignments
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.storage.arrays import ArrayReader


def main(results: Path) -> None:
    tables = {path.stem: read_alignments(path) for path in sorted((results / "alignment").glob("[0-9]*.tsv"))
              if path.stem.isdigit()}  # fmt: skip
    for states in ("tier", "thirds", "recognised"):
        settings = AlignmentSettings(
            source="textgrid", folder=str((results / "alignment/textgrid").absolute()), states=states
        )
        equal, same, apart = 0, 0, []
        for shard, table in tables.items():
            utterances = [Utterance(name, "", f"{name}.mp4", "") for name in table]
            files = find_label_files({"name": results.name}, settings, utterances)
            align = aligner(settings, AlignmentSources(labels=files))
            with ArrayReader(results / f"audio/{shard}.h5") as audio:
                for one in utterances:
                    found, own = align(one, audio.array(one.id, "samples")).alignment, table[one.id]
                    equal += found.words == own.words and found.phones == own.phones
                    same += found == own
                    apart += [abs(a.end - b.end) for a, b in zip(found.states, own.states, strict=True)]
        print(
            f"states: {states:10}  {equal} of {sum(map(len, tables.values()))} utterances with equal words and phones, "
            f"{same} with equal states; ends of states {1000 * np.mean(apart):.1f} ms apart on average, 99 % within "
            f"{1000 * np.percentile(apart, 99):.0f} ms"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
