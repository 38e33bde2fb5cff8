"""One call into eSpeak NG: a JSON request on standard input, the answer on standard output.

:mod:`visualspeech.speech.tts` runs this file as a separate program (``python -P espeak.py``). eSpeak NG's output is
reproducible bit for bit only for the first utterance of a process, and for voices with breath (``en-us+f3``) only with
a seed. A crash of the C library ends only that process.
Only the standard library and ``espeakng_loader`` are imported, for a fast start.

Requests: ``{"say": text, "voice": name, "rate": words per minute, "pitch": 0..100}``, answered by one JSON line
``{"rate", "events"}`` and the samples (16 bit, mono); or ``{"pronounce": [words], "voice": name}``, answered by one
JSON line ``{"pronounced": [[mnemonics of a word], ...]}``. With ``"marks": true`` mnemonics keep their stress marks.
With ``"phonemes": true`` a text may hold words as mnemonics in double square brackets.
"""

import ctypes
import json
import sys

# Names and numbers of speak_lib.h
SYNCHRONOUS = 2
PHONEME_EVENTS, DO_NOT_EXIT = 0x0001, 0x8000
UTF8, PHONEMES = 0x001, 0x100
RATE, PITCH = 1, 3
WORD, PHONEME = 1, 7
SEED = 1
STRESS_MARKS = "',%=|\""


class _Id(ctypes.Union):
    _fields_ = [("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8)]


class _Event(ctypes.Structure):
    _fields_ = [
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", _Id),
    ]


_Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(_Event))


class Engine:
    """The loaded library with a selected voice; ``rate`` is its sample rate in Hz."""

    def __init__(self, voice: str) -> None:
        import espeakng_loader

        self.native = ctypes.CDLL(espeakng_loader.get_library_path())
        data = espeakng_loader.get_data_path().encode()
        self.rate = self.native.espeak_Initialize(SYNCHRONOUS, 0, data, PHONEME_EVENTS | DO_NOT_EXIT)
        if self.rate <= 0:
            raise RuntimeError("eSpeak NG cannot read its data")
        if self.native.espeak_SetVoiceByName(voice.encode()) != 0:
            raise ValueError(f"eSpeak NG has no voice {voice!r}; give an English one such as en-us or en-gb")

    def pronounce(self, word: str, marks: bool = False) -> list[str]:
        """Phoneme mnemonics of one word, on request with stress marks (``'`` primary, ``,`` secondary)."""
        function = self.native.espeak_TextToPhonemes
        function.restype = ctypes.c_char_p
        pointer = ctypes.c_char_p(word.encode("utf-8"))
        phonemes = []
        while pointer.value:
            text = function(ctypes.byref(pointer), UTF8, ord("_") << 8) or b""
            phonemes += text.decode("utf-8", "replace").replace(" ", "_").split("_")
        phonemes = [phoneme for phoneme in phonemes if phoneme.strip(STRESS_MARKS)]
        return phonemes if marks else [phoneme.strip(STRESS_MARKS) for phoneme in phonemes]

    def say(self, text: str, rate: int, pitch: int, phonemes: bool = False) -> tuple[list, bytes]:
        """The events of a spoken text and its samples (16 bit, mono).

        Events are ``["word", sample, first character, characters]`` and ``["phone", sample, mnemonic]``.
        """
        events, chunks = [], []

        def receive(samples, count, event):
            if samples and count:
                chunks.append(ctypes.string_at(samples, 2 * count))
            i = 0
            while event[i].type:
                if event[i].type == WORD:
                    events.append(["word", event[i].sample, event[i].text_position - 1, event[i].length])
                elif event[i].type == PHONEME:
                    name = event[i].id.string.decode("utf-8", "replace").strip(STRESS_MARKS)
                    events.append(["phone", event[i].sample, name])
                i += 1
            return 0

        callback = _Callback(receive)
        self.native.espeak_ng_SetRandSeed(ctypes.c_long(SEED))  # of breath; it is the time of day otherwise
        self.native.espeak_SetSynthCallback(callback)
        self.native.espeak_SetParameter(RATE, rate, 0)
        self.native.espeak_SetParameter(PITCH, pitch, 0)
        data = text.encode("utf-8")
        flags = UTF8 | (PHONEMES if phonemes else 0)
        self.native.espeak_Synth(data, len(data) + 1, 0, 0, 0, flags, None, None)
        self.native.espeak_Synchronize()
        return events, b"".join(chunks)


def main() -> int:
    """Answer the request on standard input; on failure, exit status 2 and a message on standard error."""
    request = json.load(sys.stdin)
    try:
        engine = Engine(request["voice"])
        if "pronounce" in request:
            marks = request.get("marks", False)
            answer = {"pronounced": [engine.pronounce(word, marks) for word in request["pronounce"]]}
            samples = b""
        else:
            events, samples = engine.say(
                request["say"], request["rate"], request["pitch"], request.get("phonemes", False)
            )
            answer = {"rate": engine.rate, "events": events}
    except (RuntimeError, ValueError, OSError, ImportError) as error:
        print(error, file=sys.stderr)
        return 2
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + samples)
    return 0


if __name__ == "__main__":
    sys.exit(main())
