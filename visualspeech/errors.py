"""Errors that are shown to the user; their messages say what is wrong, where, and what to do."""


class VisualSpeechError(Exception):
    """Base of every error that the user can fix; shown as one message without a traceback."""


class SettingError(VisualSpeechError):
    """A setting is unknown, mistyped or out of range; the message names its key."""


class CorpusError(VisualSpeechError):
    """A corpus as a whole cannot be used (missing root, no recordings, too many rejected)."""


class StorageError(VisualSpeechError):
    """A file cannot be read or written, or does not hold what it should."""


class DamagedFile(StorageError):
    """A file is damaged, or holds something else than it should.

    Parameters
    ----------
    path : of the file
    reason : what is wrong with it: the end of the sentence "cannot read <path>: ..."
    remedy : what the user can do about it; by default what helps with a file that a run has written
    """

    def __init__(self, path, reason: str, remedy: str = "") -> None:
        remedy = remedy or "Delete the file and run the same command again to recreate it."
        super().__init__(f"cannot read {path}: {reason.rstrip('.')}. {remedy}")
        self.path, self.reason = path, reason


class DataError(VisualSpeechError):
    """Data that belong together do not match (lengths, rates, dimensions)."""


class RejectedUtterance(VisualSpeechError):
    """One utterance cannot be used; the run continues without it.

    Parameters
    ----------
    reason : what is wrong with the utterance
    remedy : what the user can do about it
    """

    def __init__(self, reason: str, remedy: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.remedy = remedy


def plain_reason(error: BaseException, most: int = 200) -> str:
    """What an exception of Python or of a library says, in one short line without its names of codecs and classes."""
    if isinstance(error, UnicodeError):
        return f"it is not UTF-8 text, byte {getattr(error, 'start', 0)}"
    said = getattr(error, "strerror", None) or str(error) or type(error).__name__
    line = " ".join(said.split())
    return line if len(line) <= most else f"{line[:most]} ..."
