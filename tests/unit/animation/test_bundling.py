import json

import numpy as np
import pytest

from tests.unit.animation import speakers
from tests.unit.animation.faces import POINTS, draw
from tests.unit.face import heads
from visualspeech.animation.bundle import DESCRIPTION, FILES, SpeakerBundle
from visualspeech.animation.bundling import RecordedFaces, bundle_speaker
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DamagedFile, DataError, SettingError, StorageError
from visualspeech.face.aam.reference import sample_faces
from visualspeech.face.pose import estimate, to_frontal
from visualspeech.media.encoding import write_video
from visualspeech.models.rest import resting_face
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import to_table
from visualspeech.speech.phones import PHONES
from visualspeech.speech.spoken import speak_text, state_shares, timed
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.tables import write_table

PARTS = ("model", "aam", "reference", "head")
SPOKEN = timed([("sil", 0, 0.4), ("aa", 0.4, 0.8), ("sil", 0.8, 1.2)], shares={"aa": (0.2, 0.5, 0.3)})


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The files of a run: two utterances for training and one for testing, each of 30 frames."""
    folder = tmp_path_factory.mktemp("run")
    made = SpeakerBundle.load(speakers.make(folder / "made")).speaker
    utterances = []
    writers = [ArrayWriter(folder / f"{name}.h5") for name in RecordedFaces._fields]
    landmarks, pose, textures, parameters = (writer.__enter__() for writer in writers)
    for number, split in enumerate(("train", "train", "test")):
        name, points = f"u{number}", heads.record(30, seed=number, mouth=5).points.astype(np.float32)
        write_video(folder / f"{name}.mp4", (draw(one) for one in points), 25.0)
        turned = estimate(points, made.head, rate=25.0)
        frontal = to_frontal(points, turned, made.head)
        faces = sample_faces((draw(one) for one in points), points, frontal, made.reference, rate=25.0)
        landmarks.add(name, {"points": points}, 25.0)
        pose.add(name, {"rotation": turned.rotation, "translation": turned.translation}, 25.0)
        textures.add(name, faces.arrays(), 25.0)
        parameters.add(name, {"appearance": made.aam.encode_faces(faces).parameters}, 25.0)
        utterances.append(Utterance(name, "s", str(folder / f"{name}.mp4"), "ah", split=split))
    for writer in writers:
        writer.__exit__(None, None, None)
    write_table(folder / "alignment.tsv", to_table({one.id: SPOKEN for one in utterances}))
    return folder, utterances


def bundled(run, path, utterances=None, **given):
    folder, accepted = run
    files = {name: folder / "made" / FILES[name] for name in PARTS} | given.pop("files", {})
    readers = [ArrayReader(folder / f"{name}.h5") for name in RecordedFaces._fields]
    about = {"seconds": 1.0, "corpus": "drawn", "model": "F-4", "consent": speakers.CONSENT} | given
    table = [folder / "alignment.tsv"]
    bundle_speaker(
        path, files, PHONES, accepted if utterances is None else utterances, table, RecordedFaces(*readers), **about
    )
    return SpeakerBundle.load(path)


def test_a_speaker_is_made_of_the_files_of_a_run(run, tmp_path):
    folder, utterances = run
    bundle = bundled(run, tmp_path / "speaker")
    assert (bundle.corpus, bundle.model, bundle.consent) == ("drawn", "F-4", speakers.CONSENT)
    assert bundle.shares == {name: pytest.approx(part, abs=1e-5) for name, part in state_shares([SPOKEN]).items()}
    with ArrayReader(folder / "parameters.h5") as parameters:
        training = [(SPOKEN, parameters.array(one, "appearance"), 25.0) for one in ("u0", "u1")]
    np.testing.assert_array_equal(bundle.rest, resting_face(lambda: iter(training)))
    # One second is asked for: one recording for training is enough, the test utterance is not among them.
    assert len(bundle.background) == 30 and bundle.background.media[0] in [one.media for one in utterances[:2]]
    assert len(bundle.background.shapes[0]) == 2 * POINTS.size


def test_the_background_can_be_named(run, tmp_path):
    bundle = bundled(run, tmp_path / "speaker", background=["u2", "u0"])
    assert [one[-6:] for one in bundle.background.media] == ["u0.mp4", "u2.mp4"]
    with pytest.raises(SettingError, match="`speak.background`: u7, u9 is no accepted utterance"):
        bundled(run, tmp_path / "other", background=["u7", "u0", "u9"])
    assert not (tmp_path / "other").exists()


def test_what_cannot_be_bundled_leaves_no_folder(run, tmp_path):
    with pytest.raises(StorageError, match="cannot read .*nowhere"):
        bundled(run, tmp_path / "speaker", files={"head": tmp_path / "nowhere"})
    with pytest.raises(DataError, match="no recording to take the background from"):
        bundled(run, tmp_path / "speaker", utterances=run[1][2:])
    assert not list(tmp_path.iterdir())


def test_a_dictionary_goes_with_the_speaker(run, tmp_path):
    (tmp_path / "own.dict").write_text("quux\tkʰ w ɐ k s\ntomato\tt ə m ɑ t ow\n", encoding="utf-8")
    given = {"path": str(tmp_path / "own.dict"), "phones": {"name": "ipa", "table": {}}}
    bundle = bundled(run, tmp_path / "speaker", dictionary=given)
    (tmp_path / "own.dict").unlink()  # the folder holds all that it needs
    bundle = SpeakerBundle.load((tmp_path / "speaker").rename(tmp_path / "moved"))
    assert bundle.lexicon().pronunciations("quux") == (("k", "w", "ah", "k", "s"),)
    assert bundle.pronunciation("tomato") == ("t", "ah", "m", "aa", "t", "ow")
    said = next(iter(speak_text("Quux.", shares=bundle.shares, own=bundle.pronunciation)))
    assert [one.label for one in said.alignment.phones if one.label != "sil"] == ["k", "w", "ah", "k", "s"]
    assert bundled(run, tmp_path / "plain").pronunciation is None


@pytest.mark.parametrize("content", [b"", b"quux K QQ\n", b"\xff" * 100, b"quux\n"])
def test_a_damaged_dictionary_is_a_sentence(run, tmp_path, content):
    (tmp_path / "own.dict").write_text("quux K W AH1 K S\n")
    given = {"path": str(tmp_path / "own.dict"), "phones": {"name": "arpabet", "table": {}}}
    path = tmp_path / "speaker" / FILES["dictionary"]
    bundled(run, tmp_path / "speaker", dictionary=given)
    path.write_bytes(content)
    with pytest.raises(DataError, match="is not the file that this speaker was made of"):
        SpeakerBundle.load(tmp_path / "speaker")
    about = json.loads((tmp_path / "speaker" / DESCRIPTION).read_text())
    about["parts"]["dictionary"] = file_digest(path)
    (tmp_path / "speaker" / DESCRIPTION).write_text(json.dumps(about))
    with pytest.raises(DamagedFile, match="dictionary.txt: it is no pronunciation dictionary"):
        SpeakerBundle.load(tmp_path / "speaker")
