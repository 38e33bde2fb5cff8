import numpy as np
import pytest

from tests.unit.face.aam.faces import POINTS, moving_faces, smooth_picture
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.evaluation.viseme_pictures import mean_gestures, viseme_pictures
from visualspeech.face.aam.model import Aam, AamSettings, fit
from visualspeech.face.aam.modes import face_pictures, mode_pictures
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.aam.training import fit_aam
from visualspeech.face.coding_files import load_coding, read_coding_header
from visualspeech.face.drift import Faces, remove
from visualspeech.face.point_sets import to_points, to_vector
from visualspeech.features.visemes.classes import VisemeClasses
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.models import write_model

SETTINGS = AamSettings(
    shape={"components": 8}, texture={"components": 12}, appearance={"energy": 0.98}, iterations=20, seed=1
)


@pytest.fixture(scope="module")
def faces():
    return POINTS.select(moving_faces(300))


@pytest.fixture(scope="module")
def reference(faces):
    return fit_reference([faces], POINTS, ReferenceSettings(texture_pixels=400))


@pytest.fixture(scope="module")
def data(faces, reference):
    """Shapes, and textures that follow the shapes: colour with the jaw, and light of their own."""
    generator = np.random.default_rng(5)
    shapes = to_vector(faces)
    patterns = [smooth_picture(120, 120, seed)[reference.pixels[:, 0], reference.pixels[:, 1]].T for seed in range(6)]
    patterns = np.stack([p.reshape(-1) - p.mean() for p in patterns])
    jaw = (shapes[:, 59] - shapes[:, 59].mean()) / shapes[:, 59].std()
    weights = np.column_stack([jaw, 0.5 * jaw**2, generator.standard_normal((len(jaw), 4)) * 0.4])
    textures = 120 + 0.3 * weights @ patterns + generator.normal(0, 1, (len(jaw), patterns.shape[1]))
    return shapes, textures.astype(np.float32)


@pytest.fixture(scope="module")
def aam(data):
    return fit(data[0], ArrayRows(data[1]), POINTS, SETTINGS)


def test_equations_3_5_6_7_8_written_out(data, aam):
    shapes, textures = data
    parameters = aam.encode(shapes[:9], textures[:9])
    ns, nt, n = aam.sizes
    assert [x.shape for x in parameters] == [(9, ns), (9, nt), (9, n), (9,)]
    for j in range(9):
        a = np.array([np.dot(shapes[j] - aam.shape_mean, row) for row in aam.shape_components])
        b = np.array([np.dot(textures[j] - aam.texture_mean, row) for row in aam.texture_components])
        joint = np.concatenate([aam.shape_weight * a, b])
        v = np.array([np.dot(joint, row) for row in aam.appearance_components])
        np.testing.assert_allclose(parameters.shape[j], a, atol=1e-3)
        np.testing.assert_allclose(parameters.texture[j], b, atol=1e-2)
        np.testing.assert_allclose(parameters.appearance[j], v, atol=1e-2)
        left = textures[j] - aam.texture_mean - b @ aam.texture_components
        assert parameters.residual[j] == pytest.approx(np.sqrt(np.mean(left**2)), rel=1e-3)
        s = aam.shape_mean + sum(v[i] * aam.shape_basis[i] for i in range(n))
        t = aam.texture_mean + sum(v[i] * aam.texture_basis[i] for i in range(n))
        decoded = aam.decode(v[None])
        np.testing.assert_allclose(decoded[0][0], s, atol=1e-3)
        np.testing.assert_allclose(decoded[1][0], t, atol=1e-2)


def test_shape_and_texture_parameters_of_v_decode_to_the_same_face(data, aam):
    v = aam.encode(*data).appearance
    shape, texture = aam.decode(v)
    np.testing.assert_allclose(aam.shape_mean + aam.shape_parameters(v) @ aam.shape_components, shape, atol=1e-3)
    np.testing.assert_allclose(
        aam.texture_mean + aam.texture_parameters(v) @ aam.texture_components, texture, atol=1e-2
    )


def test_bases_are_orthonormal_and_parameters_uncorrelated_with_the_stated_variances(data, aam):
    parameters = aam.encode(*data)
    for basis, values, variances in (
        (aam.shape_components, parameters.shape, aam.shape_variances),
        (aam.texture_components, parameters.texture, aam.texture_variances),
        (aam.appearance_components, parameters.appearance, aam.appearance_variances),
    ):
        np.testing.assert_allclose(basis @ basis.T, np.eye(len(basis)), atol=1e-4)
        np.testing.assert_allclose(values.mean(axis=0), 0, atol=1e-3 * np.sqrt(variances[0]))
        spread = np.cov(values.T.astype(np.float64), bias=True)
        np.testing.assert_allclose(spread, np.diag(variances), atol=1e-3 * variances[0])
    assert aam.energies[2] >= 0.98


def test_with_all_joint_components_nothing_is_lost(data):
    shapes, textures = data
    whole = fit(
        shapes,
        ArrayRows(textures),
        POINTS,
        AamSettings(shape={"components": 8}, texture={"components": 12}, appearance={"components": 20}),
    )
    parameters = whole.encode(shapes, textures)
    np.testing.assert_allclose(whole.shape_parameters(parameters.appearance), parameters.shape, atol=1e-3)
    np.testing.assert_allclose(whole.texture_parameters(parameters.appearance), parameters.texture, atol=2e-2)


def test_weighting_balances_shape_and_texture_or_leaves_them(data, aam):
    shapes, textures = data
    weighted = aam.shape_weight**2 * aam.shape_variances.sum()
    assert weighted == pytest.approx(aam.texture_variances.sum(), rel=1e-6)
    plain = fit(shapes, ArrayRows(textures), POINTS, AamSettings(shape={"energy": 0.99}, weighting="none"))
    assert plain.shape_weight == 1


def test_saved_model_reads_back_the_same(tmp_path, data, aam):
    aam.save(tmp_path / "aam.safetensors")
    again = Aam.load(tmp_path / "aam.safetensors")
    for one, two in zip(aam.encode(*data), again.encode(*data), strict=True):
        np.testing.assert_array_equal(one, two)
    assert again.settings == aam.settings
    assert again.points is POINTS
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "aam.safetensors").read_bytes()


def test_training_from_files_draws_frames_and_takes_the_drift_out(tmp_path, data):
    shapes, textures = data
    generator = np.random.default_rng(3)
    with ArrayWriter(tmp_path / "textures.h5") as out:
        for number in range(6):
            rows = slice(50 * number, 50 * number + 50)
            light, seat = 20 * generator.standard_normal(), 5 * generator.standard_normal()
            shape, texture = (shapes[rows] + seat).astype(np.float32), textures[rows] + light
            out.add(f"u{number}", Faces.of(shape, texture, rate=25.0).arrays(), 25.0)
    ids = [f"u{number}" for number in range(5)]
    with ArrayReader(tmp_path / "textures.h5") as arrays:
        one = fit_aam(arrays, ids, POINTS, SETTINGS, folder=str(tmp_path))
        two = fit_aam(arrays, ids[::-1], POINTS, SETTINGS, folder=str(tmp_path))
        few = fit_aam(arrays, ids, POINTS, AamSettings(images=40, texture={"components": 5}), folder=str(tmp_path))
        u5 = Faces.read(arrays, "u5")
        with pytest.raises(SettingError, match="aam.texture.components: 250` is more .*: 250 images give 249 at most"):
            fit_aam(arrays, ids, POINTS, AamSettings(texture={"components": 250}), folder=str(tmp_path))
    np.testing.assert_array_equal(one.texture_components, two.texture_components)
    assert len(few.texture_components) == 5
    assert list(tmp_path.iterdir()) == [tmp_path / "textures.h5"]
    coded = one.encode_faces(u5)
    plain = one.encode(*remove(u5.shape, u5.texture, u5.reference, one.drift))
    np.testing.assert_allclose(coded.parameters, plain.appearance, atol=1e-3)
    np.testing.assert_array_equal(coded.details["shape"], plain.shape)
    assert coded.details["residual"].mean() < 2
    np.testing.assert_allclose(coded.details["points"] + coded.offset.shape, u5.shape, atol=1e-4)
    movement = textures[:250].reshape(5, 50, -1)
    movement = np.square(movement - movement.mean(axis=1, keepdims=True)).sum(axis=2).mean()
    assert one.totals[1] == pytest.approx(movement, rel=1e-3)  # what is left is movement inside utterances
    with pytest.raises(DataError, match="no training frames"):
        fit_aam(arrays, [], POINTS, SETTINGS)


@pytest.mark.parametrize(
    "wrong",
    [
        {"shape": {"energy": 1.5}},
        {"shape": {}},
        {"shape": {"energy": 0.9, "components": 3}},
        {"texture": {"energy": 0.9, "at_most": 0}},
        {"texture": {"modes": 3}},
        {"texture": {"components": 0}},
        {"appearance": {"components": 2.5}},
        {"weighting": "equal"},
        {"images": 1},
        {"iterations": 0},
    ],
)
def test_wrong_settings_are_refused_by_name(wrong):
    with pytest.raises(SettingError, match=next(iter(wrong))):
        AamSettings(**wrong)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"shape": {"components": 50}, "images": 50}, "aam.shape.components: 50.*: 50 images give 49"),
        ({"texture": {"components": 300}, "images": 300}, "aam.texture.components: 300.*: 300 images give 299"),
        (
            {"appearance": {"components": 1200}, "images": 1000},
            "aam.appearance.components: 1200.*: 1000 images give 999",
        ),
        (
            {name: {"components": number} for name, number in (("shape", 5), ("texture", 10), ("appearance", 16))},
            "aam.appearance.components: 16.*: 5 shape and 10 texture components give 15 at most. Ask for fewer",
        ),
    ],
)
def test_more_modes_than_there_can_be_are_refused_before_any_data(wrong, said):
    with pytest.raises(SettingError, match=said):
        AamSettings(**wrong)


def test_more_shape_modes_than_coordinates_of_the_point_set_are_refused_before_any_data():
    with pytest.raises(SettingError, match="aam.shape.components: 93.*: 92 tracked coordinates give 92"):
        AamSettings(shape={"components": 93}).check_possible(20000, POINTS.freedom)


def test_points_and_textures_decode_apart_and_a_coding_is_read_by_its_kind(tmp_path, data, aam):
    v = aam.encode(*data).appearance
    shape, texture = aam.decode(v)
    np.testing.assert_array_equal(aam.decode_points(v), to_points(shape))
    np.testing.assert_array_equal(aam.decode_texture(v), texture)
    aam.save(tmp_path / "aam.safetensors")
    header = read_coding_header(tmp_path / "aam.safetensors")
    assert header == ("aam", "lower_face_51", dict(zip(("shape", "texture", "appearance"), aam.sizes, strict=True)))
    coding = load_coding(tmp_path / "aam.safetensors")
    assert coding.size == aam.sizes[2]
    np.testing.assert_array_equal(coding.decode_points(v), aam.decode_points(v))
    for wrong in ({"kind": "head"}, {"kind": "x", "points": "", "sizes": {}}):
        write_model(tmp_path / "other.safetensors", {}, wrong)
        with pytest.raises(StorageError, match="other.safetensors: .*(settings|unknown kind)"):
            load_coding(tmp_path / "other.safetensors")


def test_more_modes_than_the_data_has_and_data_that_does_not_fit_are_refused(data, aam):
    shapes, textures = data
    shape = AamSettings(shape={"components": 92})
    with pytest.raises(SettingError, match="20 directions only"):
        fit(shapes[:21], ArrayRows(textures[:21]), POINTS, shape)
    with pytest.raises(SettingError, match="at most 29"):
        fit(shapes[:30], ArrayRows(textures[:30]), POINTS, AamSettings(texture={"components": 30}))
    with pytest.raises(DataError, match="300 training shapes but 299"):
        fit(shapes, ArrayRows(textures[:-1]), POINTS)
    with pytest.raises(DataError, match="51 points of lower_face_51"):
        fit(shapes[:, 1:], ArrayRows(textures), POINTS)
    with pytest.raises(DataError, match="do not fit this AAM"):
        aam.encode(shapes[:, 1:], textures)


@pytest.mark.parametrize("kind", ["shape", "texture", "appearance"])
def test_pictures_of_modes_differ_on_both_sides_of_the_mean(aam, reference, kind):
    low, mean, high = mode_pictures(aam, reference, kind, 0, width=90)
    assert low.shape == mean.shape == high.shape and mean.shape[1] == 90
    assert not np.array_equal(low, mean) and not np.array_equal(high, mean)
    assert (mean == 255).all(axis=2).mean() < 0.7
    with pytest.raises(SettingError, match="no shape mode 99"):
        mode_pictures(aam, reference, "shape", 99)
    with pytest.raises(SettingError, match="no kind"):
        mode_pictures(aam, reference, "colour", 0)


def test_pictures_of_faces_are_those_of_the_modes(aam, reference):
    parameters = np.zeros((3, len(aam.appearance_components)))
    parameters[:, 0] = np.array([-2, 0, 2]) * np.sqrt(aam.appearance_variances[0])
    modes = mode_pictures(aam, reference, "appearance", 0, width=90)
    for one, other in zip(face_pictures(aam, reference, parameters, width=90), modes, strict=True):
        assert one.shape == other.shape and np.abs(one.astype(int) - other).max() <= 2


def test_faces_of_the_most_frequent_visemes(aam, reference):
    means = np.random.default_rng(1).normal(size=(20, 8, len(aam.appearance_components))) * 0.3
    classes = VisemeClasses((means * np.sqrt(aam.appearance_variances)).astype(np.float32), np.arange(20))
    shown = mean_gestures(classes)
    assert [number for number, _, _ in shown[:3]] == [19, 18, 17] and shown[0][1] == 19 / sum(range(20))
    assert sum(share for _, share, _ in shown) == pytest.approx(1) and np.array_equal(shown[0][2], classes.means[19])
    png = viseme_pictures(classes, aam, reference, count=4)
    assert png.startswith(b"\x89PNG") and png == viseme_pictures(classes, aam, reference, count=4)
