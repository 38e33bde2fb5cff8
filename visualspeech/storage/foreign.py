"""Text files that people give: read with a bound, in the encodings that their programs write."""

import os
import stat
from pathlib import Path

MAX_TEXT = 1_000_000  # bytes of a transcript; 18 hours of speech are about that
_BLOCK = 1_000_000  # bytes that are read at a time


def read_bytes(path: str | Path, most: int = MAX_TEXT) -> bytes:
    """The bytes of a file of text, at most ``most``.

    Raises
    ------
    OSError
        It cannot be read, is no regular file, or is too large for a text; ``strerror`` says which.
    """
    # Without waiting: a pipe may have nobody who writes to it.
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(None, "it is a folder" if stat.S_ISDIR(status.st_mode) else "it is no regular file")
        if status.st_size > most:
            raise OSError(None, f"it is larger than {most:,} bytes")
        return b"".join(iter(lambda: os.read(descriptor, _BLOCK), b""))
    finally:
        os.close(descriptor)


def decoded(data: bytes) -> str:
    """Text that is UTF-8 (with or without a byte-order mark), UTF-16 with one, or else Windows-1252."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")
