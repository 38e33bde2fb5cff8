"""Corpora: adapters that yield :class:`Utterance` records, the split, and the check of the recordings."""
