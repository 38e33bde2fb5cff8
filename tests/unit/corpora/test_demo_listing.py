"""The demo corpus as a list."""

import subprocess
import sys
from pathlib import Path

import pytest

from visualspeech.corpora.demo.listing import media_path, utterances
from visualspeech.corpora.demo.sentences import SENTENCES
from visualspeech.corpora.records import shard_of
from visualspeech.errors import SettingError
from visualspeech.speech.tts import letters_to_sounds

VOWELS = "aa ae ah ao aw ay eh er ey ih iy ow oy uh uw"
CONSONANTS = "b ch d dh f g hh jh k l m n ng p r s sh t th v w y z zh"


def test_sixty_utterances_with_ids_of_their_own():
    found = utterances({"root": "media"})
    assert len(found) == 60
    assert len({u.id for u in found}) == 60 and [u.id for u in found] == sorted(u.id for u in found)
    assert len(set(SENTENCES)) == len(SENTENCES)
    assert all(Path(u.media) == Path("media") / f"{u.id}.mp4" and u.transcript in SENTENCES for u in found)


def test_the_seed_chooses_and_repeats():
    few = {"root": "media", "utterances": 8}
    assert utterances(few) == utterances(few | {"seed": 1}) != utterances(few | {"seed": 2})


def test_with_shards_the_recordings_lie_in_the_folder_of_their_shard():
    for utterance in utterances({"root": "media", "utterances": 12, "shards": 3}):
        shard = shard_of(utterance.id, 3)
        assert (
            Path(utterance.media)
            == media_path("media", utterance.id, shard)
            == Path(f"media/{shard}") / (utterance.id + ".mp4")
        )


@pytest.mark.parametrize(
    ("corpus", "key"),
    [
        ({}, "root"),
        ({"root": "m", "utterances": 0}, "utterances"),
        ({"root": "m", "utterances": 1000}, "utterances"),
        ({"root": "m", "utterances": "many"}, "utterances"),
        ({"root": "m", "shards": 0}, "shards"),
    ],
)
def test_bad_settings_name_their_key(corpus, key):
    with pytest.raises(SettingError, match=key):
        utterances(corpus)


def test_the_sentences_hold_every_phone():
    words = {word.strip(".,?!").lower() for sentence in SENTENCES for word in sentence.split()}
    spoken = {phone for phones in letters_to_sounds(sorted(words)).values() for phone in phones}
    assert spoken == set(VOWELS.split()) | set(CONSONANTS.split())


def test_listing_imports_nothing_heavy():
    code = (
        "import sys, visualspeech.corpora.demo.listing; print([m for m in ('numpy', 'cv2', 'av') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
