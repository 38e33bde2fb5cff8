"""Errors whose message is meant for a person: what is wrong, where, and what to do."""


class VisualSpeechError(Exception):
    """Base of every error that a user can mend; shown as one message, without a traceback."""


class SettingError(VisualSpeechError):
    """A setting is unknown, mistyped or out of range; the message names its key."""


class CorpusError(VisualSpeechError):
    """A corpus as a whole cannot be used (missing root, no recordings, too many rejected)."""


class StorageError(VisualSpeechError):
    """A file cannot be read or written as it should."""


class DataError(VisualSpeechError):
    """Streams that belong together do not fit (lengths, rates, dimensions)."""


class RejectedUtterance(VisualSpeechError):
    """One utterance cannot be used; the corpus goes on without it.

    Parameters
    ----------
    reason : what is wrong with it, for a person
    remedy : what the person can do about it
    """

    def __init__(self, reason: str, remedy: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.remedy = remedy
