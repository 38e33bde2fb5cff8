import numpy as np
import pytest

from visualspeech.animation.label import labelled, title_bar, title_height


@pytest.mark.parametrize("size", [(40, 30), (144, 176), (288, 360), (1080, 1920)])
def test_the_label_is_small_in_the_corner_and_legible(size):
    picture = np.full((*size, 3), 128, np.uint8)
    result = labelled(picture, "synthetic")
    changed = np.any(result != picture, axis=2)
    rows, columns = np.nonzero(changed)
    assert rows.min() > size[0] * 0.55 and columns.min() > size[1] * 0.25
    assert changed.mean() < 0.15
    assert result[changed].max() > 180 and result[changed].min() < 80
    assert np.all(picture == 128)


def test_titles_stand_over_their_panels():
    bar = title_bar(["original", "a title that is much too long for its panel, really"], [100, 60], title_height(144))
    assert bar.shape == (title_height(144), 160, 3) and bar.shape[0] % 2 == 0
    for part in (bar[:, :100], bar[:, 100:]):
        columns = np.nonzero((part > 100).any(axis=(0, 2)))[0]
        assert len(columns) and abs((columns[0] + columns[-1]) / 2 - (part.shape[1] - 1) / 2) < 6


def test_letters_that_cannot_be_drawn_do_no_harm():
    assert title_bar(["mündlich"], [100], 22).shape == (22, 100, 3)
    assert title_bar([""], [100], 22).shape == (22, 100, 3)
