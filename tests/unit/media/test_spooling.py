import tempfile

import numpy as np
import pytest

from visualspeech.errors import StorageError
from visualspeech.media.spooling import Spool


def test_what_was_put_in_comes_out():
    rows = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)
    spool = Spool(np.float32, 3)
    for part in np.split(rows, [7, 7, 30]):
        assert np.array_equal(spool[:], rows[: len(spool)])  # reading between does not harm
        spool.append(part)
    assert len(spool) == 50 and np.array_equal(spool[:], rows)
    assert np.array_equal(spool[5:31], rows[5:31]) and spool[45:99].shape == (5, 3) and spool[9:9].shape == (0, 3)
    plain = Spool(np.int16)
    plain.append(np.arange(5))
    assert np.array_equal(plain[1:3], [1, 2]) and plain[1:3].dtype == np.int16
    with pytest.raises(ValueError, match="shape"):
        spool.append(rows[:, :2])
    with pytest.raises(ValueError, match="row by row"):
        spool[::2]


def test_a_temporary_folder_that_cannot_be_written(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    with pytest.raises(StorageError, match="cannot write temporary files.*TMPDIR"):
        Spool()
