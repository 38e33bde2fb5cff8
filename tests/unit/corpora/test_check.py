"""Every bad recording is found, with a sentence that names the file and the remedy; good ones pass in silence."""

import numpy as np
import pytest

from tests import synthetic
from tests.paths import grid_root
from visualspeech.corpora import check
from visualspeech.corpora.check import check_recording
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.findings import REJECT, WARN
from visualspeech.corpora.records import Utterance
from visualspeech.media import reading
from visualspeech.speech.lexicon import Lexicon

SECONDS = 2.0


def checked(path, transcript="hello there", unknown=(), settings=None, **fields):
    utterance = Utterance("u1", "s", str(path), transcript, **fields)
    result = check_recording(utterance, lambda text: list(unknown), settings or CheckSettings())
    for finding in result.findings:
        assert finding.file == str(path) and finding.id == "u1" and finding.stage == "check"
        assert finding.finding and finding.remedy.endswith(".")
    rejections = [finding for finding in result.findings if finding.level == REJECT]
    assert (result.rejected is None) == (result.samples is not None) == (not rejections)
    return result


def rejected(path, **fields):
    result = checked(path, **fields)
    assert result.rejected is not None, result.findings
    return result.rejected.reason


def warnings(path, **fields):
    result = checked(path, **fields)
    assert result.rejected is None, result.rejected
    # What the check accepts, later stages must be able to read, with as many frames.
    utterance = {name: fields[name] for name in ("start", "end") if name in fields}
    assert sum(1 for _ in reading.read_frames(path, **utterance)) == result.frames
    return [finding.finding for finding in result.findings if finding.level == WARN]


def record(tmp_path, name="a.mp4", seconds=SECONDS, **arguments):
    return synthetic.record(tmp_path / name, seconds, **arguments)


def test_a_good_recording_passes_in_silence(tmp_path):
    path = record(tmp_path)
    result = checked(path)
    assert result.findings == [] and result.frames == 50
    assert result.samples.dtype == np.int16 and abs(len(result.samples) / 16000 - SECONDS) < 0.1
    np.testing.assert_allclose(result.samples / 32767, reading.read_audio(path, 16000), atol=1e-4)
    assert checked(path).digest == result.digest


def test_unreadable_files(tmp_path):
    assert rejected(tmp_path / "none.mp4") == "the file does not exist"
    (tmp_path / "empty.mp4").write_bytes(b"")
    assert "empty: 0 bytes" in rejected(tmp_path / "empty.mp4")
    (tmp_path / "garbage.mp4").write_bytes(np.random.default_rng(0).bytes(5000))
    assert rejected(tmp_path / "garbage.mp4").startswith("unreadable media file")
    assert rejected(tmp_path) == "the recording is a folder"
    (tmp_path / "link.mp4").symlink_to(tmp_path / "none.mp4")
    assert "a link to a file that does not exist" in rejected(tmp_path / "link.mp4")


def test_the_problem_that_an_adapter_found_is_the_reason(tmp_path):
    path = record(tmp_path)
    result = checked(path, problem="its file name is not UTF-8 text", remedy="Rename the file.")
    (finding,) = result.findings
    assert (finding.finding, finding.remedy) == ("its file name is not UTF-8 text", "Rename the file.")
    assert result.rejected and not result.digest


@pytest.mark.parametrize(
    ("name", "codecs", "options"),
    [
        ("a.mp4", ("libx264", "aac"), {}),
        ("fast.mp4", ("libx264", "aac"), {"movflags": "faststart"}),
        ("a.mkv", ("libx264", "aac"), {}),
        ("a.avi", ("mpeg4", "mp2"), {}),
        ("a.webm", ("libvpx", "libopus"), {}),
    ],
)
def test_truncated_files(tmp_path, name, codecs, options):
    path = record(tmp_path, name, codecs=codecs, audio_rate=48000, options=options)
    assert checked(path).findings == []
    reason = rejected(synthetic.truncated(path, 0.6))
    assert reason.startswith("unreadable media file" if name == "a.mp4" else "truncated: its header announces 2.0")


def test_a_truncated_real_recording(tmp_path):
    if grid_root() is None:
        pytest.skip("no copy of GRID: set GRID_ROOT")
    source = next(iter(sorted(grid_root().rglob("s1/*.mpg"))))
    path = tmp_path / "cut.mpg"
    path.write_bytes(source.read_bytes())
    assert checked(path).rejected is None
    for share in (0.9, 0.5):
        assert "truncated, or damaged at its end" in rejected(synthetic.truncated(path, share))


def test_no_video_and_no_audio(tmp_path):
    import soundfile

    soundfile.write(tmp_path / "a.wav", synthetic.hum(SECONDS), 16000)
    assert rejected(tmp_path / "a.wav") == "no video stream"
    assert rejected(record(tmp_path, audio=np.zeros(0))) == "no audio stream"


def test_too_short(tmp_path):
    assert rejected(record(tmp_path, seconds=0.2)) == "only 0.20 s of video (5 frames)"


def test_silent_audio(tmp_path):
    assert rejected(record(tmp_path, audio=np.zeros(32000))) == "silent audio"
    assert "at most -8" in rejected(record(tmp_path, audio=synthetic.hum(SECONDS) * 3e-4))


@pytest.mark.parametrize("sound", ["noise", "tone", "mains"])
def test_audio_without_speech(tmp_path, sound):
    time = np.arange(32000) / 16000
    samples = {
        "noise": np.random.default_rng(0).normal(size=32000) * 0.1,
        "tone": 0.5 * np.sin(2 * np.pi * 440 * time),
        "mains": 0.1 * np.sign(np.sin(2 * np.pi * 50 * time)),
    }[sound]
    assert rejected(record(tmp_path, audio=samples)).startswith("audio without speech")


def test_transcripts_that_are_missing_empty_or_without_words(tmp_path):
    path = record(tmp_path)
    result = checked(path, transcript="")
    assert result.rejected.reason == "no transcript" and "a.txt" in result.rejected.remedy
    (tmp_path / "a.txt").write_text("\n")
    assert rejected(path, transcript="") == "the transcript a.txt is empty"
    assert rejected(path, transcript="... !") == "the transcript holds no word: '... !'"
    assert warnings(path, transcript="42") == []


def test_a_corpus_without_transcripts_asks_for_none(tmp_path):
    utterance = Utterance(id="a", speaker="s", media=str(record(tmp_path)), transcript="")
    for text in (True, False):
        found = check_recording(utterance, Lexicon().unknown_words, CheckSettings(), text)
        assert (found.rejected is None) == (not text) and (found.samples is not None) == (not text)


def test_words_that_the_dictionary_lacks(tmp_path):
    found = warnings(record(tmp_path), unknown=["qwrt", "zlb", "qwrt"])
    assert found == ["not in the pronunciation dictionary: qwrt, zlb"]


def test_8_khz_audio_is_used(tmp_path):
    path = record(tmp_path, audio_rate=8000)
    assert warnings(path) == ["audio at 8 kHz"]
    assert abs(len(checked(path).samples) / 16000 - SECONDS) < 0.1


@pytest.mark.parametrize("limit", [1.0, 0.4])
def test_clipped_audio(tmp_path, limit):
    sound = synthetic.hum(SECONDS)
    path = record(tmp_path, audio=np.clip(sound * 8, -1, 1) * limit)
    (finding,) = warnings(path)
    assert finding.startswith("clipped audio (")
    assert check.clipped_share(sound) < 0.001 < check.clipped_share(np.clip(sound, -0.2, 0.2))
    assert check.clipped_share(np.zeros(100)) == 0.0


def test_variable_frame_rate(tmp_path):
    times = np.r_[0, np.cumsum(np.random.default_rng(0).choice([1, 2, 3], 39) / 30)]
    path = record(tmp_path, "v.mkv", seconds=float(times[-1]), rate=30, times=times)
    (finding,) = warnings(path)
    assert finding.startswith("variable frame rate: ") and "100 ms" in finding


def test_odd_frame_rates(tmp_path):
    assert "5 frames per second are too few" in rejected(record(tmp_path, "5.mp4", rate=5))
    assert warnings(record(tmp_path, "15.mp4", rate=15)) == ["unusual frame rate: 15 frames per second"]
    for rate in (25, 30000 / 1001, 60, 120):
        assert warnings(record(tmp_path, "usual.mkv", rate=rate)) == []


def test_a_still_picture(tmp_path):
    path = record(tmp_path, frames=synthetic.pictures(1) * 50)
    assert warnings(path) == ["the frames never change"]


def test_sound_and_picture_of_different_length(tmp_path):
    (finding,) = warnings(record(tmp_path, audio=synthetic.hum(1.5)))
    assert finding.startswith("sound and video differ in length: 1.5")
    assert rejected(record(tmp_path, audio=synthetic.hum(0.5))).startswith("sound and video differ in length")
    early = warnings(record(tmp_path, audio=synthetic.hum(2.5), late=0.5))
    assert early == ["the video begins 0.50 s after the sound; the sound before it is left out"]


def test_damage_in_the_middle_is_survived(tmp_path):
    path = record(tmp_path, seconds=4.0)
    data = bytearray(path.read_bytes())
    middle = len(data) // 4
    data[middle : middle + 400] = bytes(400)
    path.write_bytes(data)
    result = checked(path)
    assert result.frames == 100 and any("damaged frame" in finding for finding in warnings(path))


def test_a_lost_picture_is_a_gap(tmp_path):
    times = np.delete(np.arange(60) / 25, 30)
    path = record(tmp_path, "a.mkv", seconds=2.4, times=times)
    assert warnings(path) == ["1 gap between frames, the longest 80 ms"]
    assert checked(path).frames == 60


def test_parts_of_a_recording(tmp_path):
    path = record(tmp_path)
    assert warnings(path, start=0.4, end=1.6) == []
    assert len(checked(path, start=0.4, end=1.6).samples) == 19200
    reason = rejected(path, start=1.0, end=4.0)
    assert reason == "the utterance should end at 4.00 s, but the recording ends at 2.00 s"
    assert "no frame of this segment" in rejected(path, start=7.0, end=8.0)


def test_limits_are_settings(tmp_path):
    path = record(tmp_path, rate=15)
    assert warnings(path, settings=CheckSettings(warn_rate_below=12.0)) == []
    assert "15 frames per second are too few" in rejected(path, settings=CheckSettings(min_rate=20.0))


def test_duplicates_are_found_across_files_and_shards(tmp_path):
    paths = [record(tmp_path, "a.mp4"), record(tmp_path, "b.mp4"), record(tmp_path, "c.mp4", seconds=1.0)]
    texts = ["hello", "hello", "hello"]
    utterances = [Utterance(path.stem, "s", str(path), text) for path, text in zip(paths, texts, strict=True)]
    digests = {one.id: check_recording(one, lambda text: [], CheckSettings()).digest for one in utterances}
    check.write_digests(tmp_path / "1.tsv", {name: digests[name] for name in "ac"})
    check.write_digests(tmp_path / "2.tsv", {"b": digests["b"], "broken": "", "broken too": ""})
    utterances += [Utterance(name, "s", name, "x") for name in ("broken", "broken too")]
    (finding,) = check.find_duplicates(check.read_digests([tmp_path / "1.tsv", tmp_path / "2.tsv"]), utterances[::-1])
    assert (finding.id, finding.level, finding.file) == ("b", REJECT, str(paths[1]))
    assert finding.finding == f"the same recording as {paths[0]} (utterance a)" and finding.remedy
    other = [utterances[0], Utterance("b", "s", str(paths[1]), "good bye")]
    assert "with another transcript" in check.find_duplicates(digests, other)[0].finding


def test_frame_levels_are_decibels_of_full_scale():
    sine = np.sin(2 * np.pi * 1000 * np.arange(1600) / 16000)
    np.testing.assert_allclose(check.frame_levels(0.1 * sine), -23.01, atol=0.01)
    assert check.frame_levels(np.zeros(640)).tolist() == [-200.0, -200.0]
    assert len(check.frame_levels(np.zeros(100))) == 0
