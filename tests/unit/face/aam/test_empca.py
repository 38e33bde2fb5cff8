import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.face.aam.empca import em_pca, moments, pca
from visualspeech.face.aam.rows import ArrayRows, RowFile, choose_frames


def _rows(count=600, dimension=90, seed=0, offset=100.0):
    """Rows with a spectrum that falls off, far from zero, and some noise."""
    generator = np.random.default_rng(seed)
    axes = np.linalg.qr(generator.standard_normal((dimension, dimension)))[0]
    sizes = 20 * 0.8 ** np.arange(dimension) + 0.1
    return (generator.standard_normal((count, dimension)) * sizes @ axes + offset).astype(np.float32)


def _exact(rows):
    centred = rows.astype(np.float64) - rows.mean(axis=0, dtype=np.float64)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    return sizes**2 / len(rows), axes


def test_components_and_variances_are_those_of_an_exact_decomposition():
    rows = _rows()
    variances, axes = _exact(rows)
    found = em_pca(ArrayRows(rows), components=12, iterations=20, tolerance=1e-9)
    np.testing.assert_allclose(found.eigenvalues, variances[:12], rtol=1e-4)
    assert found.total_variance == pytest.approx(variances.sum(), rel=1e-5)
    np.testing.assert_allclose(np.abs(np.sum(found.components * axes[:12], axis=1)), 1, atol=1e-3)
    np.testing.assert_allclose(found.components @ found.components.T, np.eye(12), atol=1e-5)
    np.testing.assert_allclose(found.mean, rows.mean(axis=0, dtype=np.float64), rtol=1e-6)


def test_the_iteration_converges_from_rows_it_has_not_seen(monkeypatch):
    """With a sample of a few rows the start is poor; the two steps must do the work."""
    monkeypatch.setattr("visualspeech.face.aam.empca._SAMPLE", 5)
    rows = _rows()
    variances, _ = _exact(rows)
    rough = em_pca(ArrayRows(rows), components=12, iterations=1, tolerance=0)
    found = em_pca(ArrayRows(rows), components=12, iterations=30, tolerance=1e-9)
    np.testing.assert_allclose(found.eigenvalues, variances[:12], rtol=1e-3)
    assert rough.energy <= found.energy


def test_variances_are_those_of_the_projected_rows():
    rows = _rows(seed=2)
    found = em_pca(ArrayRows(rows), components=8)
    coordinates = (rows - found.mean) @ found.components.T
    np.testing.assert_allclose(np.cov(coordinates.T, bias=True), np.diag(found.eigenvalues), atol=0.02)


@pytest.mark.parametrize("energy", [0.5, 0.9, 0.9999])
def test_energy_is_reached_with_the_least_number(energy):
    rows = _rows()
    variances, _ = _exact(rows)
    least = int(np.searchsorted(np.cumsum(variances) / variances.sum(), energy) + 1)
    found = em_pca(ArrayRows(rows), energy=energy, iterations=20, tolerance=1e-9)
    assert len(found.components) == least
    assert found.energy >= energy
    assert len(pca(rows.astype(np.float64), energy=energy).components) == least


def test_a_cap_beside_energy_holds_and_the_log_says_so(caplog):
    rows = ArrayRows(_rows())
    with caplog.at_level("WARNING", logger="visualspeech"):
        assert len(em_pca(rows, energy=0.99, at_most=5).components) == 5
    assert "the 5 components allowed hold" in caplog.text
    assert len(em_pca(rows, energy=0.5, at_most=50).components) < 10
    assert len(pca(_rows(), energy=0.99, at_most=5).components) == 5


def test_more_than_the_data_has_is_refused_with_the_number_it_has(monkeypatch):
    rows = _rows(20, 90)
    with pytest.raises(SettingError, match="at most 19"):
        em_pca(ArrayRows(rows), components=20)
    assert em_pca(ArrayRows(rows), components=19).energy == pytest.approx(1, abs=1e-4)
    flat = _rows(300, 6) @ np.random.default_rng(0).standard_normal((6, 30))
    with pytest.raises(SettingError, match="6 directions only"):
        pca(flat.astype(np.float64), components=7)
    monkeypatch.setattr("visualspeech.face.aam.empca.LIMIT", 3)
    with pytest.raises(SettingError, match="not reached with 3 components"):
        em_pca(ArrayRows(_rows()), energy=0.99)
    with pytest.raises(SettingError, match="give either"):
        em_pca(ArrayRows(rows))


def test_useless_rows_are_refused():
    with pytest.raises(DataError, match="all 9 rows are the same"):
        em_pca(ArrayRows(np.full((9, 4), 7.0)), components=1)
    with pytest.raises(DataError, match="two rows or more"):
        em_pca(ArrayRows(np.ones((1, 4))), components=1)
    with pytest.raises(DataError, match="not finite"):
        em_pca(ArrayRows(np.array([[1.0, np.nan], [2, 3], [3, 4]])), components=1)


def test_moments_do_not_cancel_far_from_zero():
    rows = _rows(2000, 30, offset=1e4)
    mean, total = moments(ArrayRows(rows))
    exact = rows.astype(np.float64)
    assert total == pytest.approx(exact.var(axis=0).sum(), rel=1e-4)
    np.testing.assert_allclose(mean, exact.mean(axis=0), rtol=1e-6)


def test_same_seed_same_bytes_from_file_or_memory(tmp_path):
    rows = _rows(1700, 40)
    file = RowFile(tmp_path, 40)
    for start in range(0, len(rows), 333):
        file.append(rows[start : start + 333])
    assert file.shape == rows.shape
    assert list(tmp_path.iterdir()) == []  # nothing that a killed process could leave
    assert [len(chunk) for chunk in file.chunks(1000)] == [1000, 700]
    one, two = em_pca(file, components=6, seed=3), em_pca(ArrayRows(rows), components=6, seed=3)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
    with pytest.raises(DataError, match="rows of 39"):
        file.append(rows[:, 1:])


def test_frames_are_drawn_over_all_utterances_and_not_by_their_order():
    lengths = {"b": 50, "a": 30, "c": 0, "d": 120}
    chosen = choose_frames(lengths, 60, seed=1)
    assert sum(map(len, chosen.values())) == 60
    assert all(np.all(np.diff(frames) > 0) and frames[-1] < lengths[name] for name, frames in chosen.items())
    again = choose_frames(dict(reversed(lengths.items())), 60, seed=1)
    assert all(np.array_equal(chosen[name], again[name]) for name in chosen)
    assert not all(np.array_equal(chosen[n], choose_frames(lengths, 60, 2).get(n, [])) for n in chosen)
    everything = choose_frames(lengths, 500, seed=1)
    assert {name: len(frames) for name, frames in everything.items()} == {"a": 30, "b": 50, "d": 120}
    assert choose_frames({}, 10, 0) == {}
