"""Recordings: adapters that all yield the same Utterance record, the split, and the check before heavy work."""
