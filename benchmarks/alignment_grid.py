"""Forced alignment of GRID against its own word times, and rejection of wrong transcripts and of sound without speech.

Run: python -m benchmarks.alignment_grid [EVERY [EVERY_REJECTED]]

Aligns every EVERY-th recording (1), and every EVERY_REJECTED-th one (4) with a wrong transcript or sound; 0 for none.
GRID's own times come from an aligner too, in steps of 10 ms. Both are weakest at the onset of the first word: GRID
often begins it at a click of the lips or a breath, 0.1 to 0.4 s before the first sound of the word. That onset is
therefore also measured against the loudness: the first time at which most of 90 ms is loud.

Rejection: a transcript with every word wrong (of a recording whose six words all differ), some words wrong, words added
at the end, words left out, an unrelated sentence, half of the recording, noise, tones, a hum. Of 12 words are two
recordings joined; a wrong word is another word of GRID in the same position, or one that GRID does not have.
"""

import time
from collections import Counter

import numpy as np

from benchmarks.command import grid, run_main
from visualspeech.corpora.grid import utterances
from visualspeech.errors import RejectedUtterance
from visualspeech.media.reading import read_audio
from visualspeech.speech.forced_alignment import Aligner, AlignmentSettings
from visualspeech.speech.recognition import RATE, speech_part
from visualspeech.speech.sound import to_int16

OTHER = (
    "She sells sea shells by the shore.",
    "The museum measures usual visions of leisure.",
    "Young children often use yellow yarn.",
    "Peter picked a paper from the pile.",
    "His father thinks that the weather is rather wild.",
)
#: Words that GRID does not have.
FOREIGN = (
    "children garden kitchen morning mountain ocean orange picture river science summer table water window".split()
)


def sound(utterance) -> np.ndarray:
    """16-bit samples at 16 kHz."""
    return to_int16(read_audio(utterance.media, RATE))


def true_words(root) -> dict[str, list[tuple[str, float, float]]]:
    """GRID's own words and times in seconds by utterance."""
    found = {}
    for path in root.rglob("*.align"):
        rows = [line.split() for line in path.read_text().splitlines() if line.strip()]
        found[path.stem] = [(word, int(a) / 25000, int(b) / 25000) for a, b, word in rows if word not in ("sil", "sp")]
    return found


def accuracy(corpus, truth) -> None:
    aligner, rejected, errors, onsets, words = Aligner(), [], [], [], []
    seconds, used = 0.0, 0.0
    for utterance in corpus:
        samples = sound(utterance)
        seconds += len(samples) / RATE
        begin = time.process_time()
        try:
            alignment = aligner.align(samples, utterance.transcript)
        except RejectedUtterance as error:
            rejected.append(f"{utterance.id}: {error}")
            continue
        finally:
            used += time.process_time() - begin
        found = [word for word in alignment.words if word.label != "sil"]
        true = truth[utterance.id]
        errors.append([(a.start - b[1], a.end - b[2]) for a, b in zip(found, true, strict=True)])
        loud = speech_part(samples, AlignmentSettings().speech_threshold, 0.0)[0] / RATE
        onsets.append((found[0].start - loud, true[0][1] - loud))
        words.append(found[0].label)
    errors, onsets = 1000 * np.array(errors), 1000 * np.array(onsets)
    size = np.abs(errors)
    print(f"aligned: {len(errors)} of {len(corpus)} ({len(errors) / len(corpus):.1%}), ", end="")
    print(f"{seconds / used:.0f} s of sound per second")
    for line in rejected:
        print(f"  {line}")
    print(f"word boundaries against GRID, ms: median {np.median(size):.1f}, mean {size.mean():.1f}, ", end="")
    print(f"within 50 ms {np.mean(size < 50):.1%}, bias (median) {np.median(errors):.1f}")
    for name, part in (("starts", errors[..., 0]), ("ends", errors[..., 1])):
        print(f"  {name:6s} by place, median absolute: {np.median(np.abs(part), axis=0).round(1)}", end="")
        print(f", bias: {np.median(part, axis=0).round(1)}")
    print(f"  without the first start: median {np.median(np.delete(size.reshape(-1, 12), 0, 1)):.1f}, ", end="")
    print(f"mean {np.delete(size.reshape(-1, 12), 0, 1).mean():.1f}")
    print("first onset against the loudness, ms: percentiles 5, 25, 50, 75, 95; more than 150 ms before it")
    for name, column in (("ours", onsets[:, 0]), ("GRID", onsets[:, 1])):
        print(f"  {name}: {np.percentile(column, [5, 25, 50, 75, 95]).round()}, {np.mean(column < -150):.1%}")
    for word in sorted(set(words)):
        chosen = np.array(words) == word
        medians = np.median(onsets[chosen], axis=0).round()
        print(f"  {word}: ours {medians[0]:.0f}, GRID {medians[1]:.0f} (n={chosen.sum()})")


def wrong_pairs(corpus, truth, every: int) -> dict:
    """Kind -> (samples, transcript) that do not belong together, one at a time."""
    random = np.random.default_rng(0)
    texts = {one.id: one.transcript.split() for one in corpus}

    def differing(one):
        candidates = [
            other for other in corpus if all(a != b for a, b in zip(texts[one.id], texts[other.id], strict=True))
        ]
        return candidates[random.integers(len(candidates))]

    def one_word(one, place):
        words = list(texts[one.id])
        others = sorted({texts[other.id][place] for other in corpus} - {words[place]})
        words[place] = others[random.integers(len(others))]
        return " ".join(words)

    def swapped(words, count, foreign):
        words = list(words)
        for place in random.choice(len(words), count, replace=False):
            listed = {texts[other.id][place % 6] for other in corpus}
            choice = FOREIGN if foreign else sorted(listed - {words[place]})
            words[place] = choice[random.integers(len(choice))]
        return " ".join(words)

    def joined(one, count, foreign=False):
        other = corpus[random.integers(len(corpus))]
        return (
            np.concatenate([sound(one), sound(other)]),
            swapped(texts[one.id] + texts[other.id], count, foreign),
        )

    def tones(_):
        t = np.arange(3 * RATE) / RATE
        chord = random.choice([220, 262, 330, 392, 440, 523, 659], 4, replace=False)
        return sum(np.sin(2 * np.pi * f * t) * (np.sin(2 * np.pi * 3 * t + f) > 0) for f in chord) * 3000

    def hum(_):
        return np.sin(2 * np.pi * 100 * np.arange(3 * RATE) / RATE) * 2000 + random.normal(0, 20, 3 * RATE)

    pairs = {
        "all six words wrong": lambda one: (sound(one), differing(one).transcript),
        "colour wrong": lambda one: (sound(one), one_word(one, 1)),
        "letter wrong": lambda one: (sound(one), one_word(one, 3)),
        "digit wrong": lambda one: (sound(one), one_word(one, 4)),
        "2 of 6 words wrong": lambda one: (sound(one), swapped(texts[one.id], 2, False)),
        "2 of 6 words wrong, none of GRID's": lambda one: (sound(one), swapped(texts[one.id], 2, True)),
        "0 of 12 words wrong": lambda one: joined(one, 0),
        "2 of 12 words wrong": lambda one: joined(one, 2),
        "3 of 12 words wrong": lambda one: joined(one, 3),
        "5 of 12 words wrong": lambda one: joined(one, 5),
        "5 of 12 words wrong, none of GRID's": lambda one: joined(one, 5, True),
        "three words too many": lambda one: (sound(one), f"{one.transcript} and then turn right"),
        "last two words missing": lambda one: (sound(one), " ".join(texts[one.id][:-2])),
        "unrelated sentence": lambda one: (sound(one), OTHER[random.integers(len(OTHER))]),
        "half of the recording": lambda one: ((samples := sound(one))[: len(samples) // 2], one.transcript),
        "noise": lambda one: (random.normal(0, random.choice([3, 300, 3000]), 3 * RATE), one.transcript),
        "tones": lambda one: (tones(one), one.transcript),
        "hum": lambda one: (hum(one), one.transcript),
        "only room sound": lambda one: (sound(one)[: round((truth[one.id][0][1] - 0.05) * RATE)], one.transcript),
    }
    return {kind: map(pair, corpus[::every]) for kind, pair in pairs.items()}


def rejections(corpus, truth, every: int) -> None:
    print("rejected:")
    aligner = Aligner()
    for kind, pairs in wrong_pairs(corpus, truth, every).items():
        reasons = Counter()
        for samples, transcript in pairs:
            samples = np.clip(np.round(samples), -32768, 32767).astype(np.int16)
            try:
                aligner.align(samples, transcript)
                reasons["accepted"] += 1
            except RejectedUtterance as error:
                reasons[error.reason.split("(")[0].split("'")[0].strip()] += 1
        share = 1 - reasons["accepted"] / sum(reasons.values())
        del reasons["accepted"]
        print(f"  {kind}: {share:.0%}   {dict(reasons)}", flush=True)


def main(every: int = 1, every_rejected: int = 4) -> None:
    root = grid()
    corpus, truth = utterances({"name": "grid", "root": str(root)}), true_words(root)
    if every:
        accuracy(corpus[::every], truth)
    if every_rejected:
        rejections(corpus, truth, every_rejected)


if __name__ == "__main__":
    run_main(main, __doc__)
