"""Settings of the synthetic voice (:mod:`visualspeech.speech.spoken`)."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting
from visualspeech.speech import tts


@dataclass(frozen=True)
class VoiceSettings(Settings):
    """Synthetic voice."""

    section = "speak.voice"
    voice: str = setting(
        tts.VOICE,
        "English voice of eSpeak NG, for example en-us or en-gb; its phones are read as American English.",
        min_length=1,
        max_length=64,
        pattern=tts.VOICE_NAME,
    )
    rate_wpm: int = setting(150, "Speaking rate in words per minute.", minimum=80, maximum=450)
    pitch: int = setting(45, "Pitch of the voice, from 0 (low) to 100 (high).", minimum=0, maximum=100)
    leading_silence: float = setting(0.4, "Silence before the first sentence, in seconds.", minimum=0, maximum=60)
    trailing_silence: float = setting(0.6, "Silence after the last sentence, in seconds.", minimum=0, maximum=60)
    sentence_pause: float = setting(0.45, "Silence between two sentences, in seconds.", minimum=0, maximum=60)
