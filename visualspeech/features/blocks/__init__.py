"""Input blocks: named features of an utterance at a system's frame rate, each learned from training utterances."""
