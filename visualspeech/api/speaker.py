"""A speaker who says any text: loaded once, then one call per text. ``visualspeech speak`` is made of this."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from visualspeech.animation.backgrounds import load_background, only_recording
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.command_paths import background_folder
from visualspeech.animation.frame_files import check_sides, check_video_name, size_of
from visualspeech.animation.performance import Performance, perform
from visualspeech.animation.speaking import frames_of, speak, speaking_frames
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.animation.timings import Timings
from visualspeech.animation.walk import WalkSettings
from visualspeech.api.speech import named
from visualspeech.errors import SettingError
from visualspeech.fields import MAX_SEED, shortened
from visualspeech.jobs import log
from visualspeech.models.inventory import needs_of_model
from visualspeech.speech.sentences import check_pronounceable
from visualspeech.speech.spoken import speak_recording, speak_sound, speak_text
from visualspeech.speech.spoken_settings import VoiceSettings
from visualspeech.storage.files import replacing


@dataclass(frozen=True)
class Said:
    """What a speaker says: an iterable of frames, a video file, or its bytes.

    The sound and the parameters of the face are there when it is made; frames are rendered as they are asked for, anew
    each time, so that memory does not grow with the text.

    Parameters
    ----------
    bundle, performance : speaker; sound and parameters
    voice : source of the sound, for the metadata of the video
    settings : of the rendering
    spoken : words and phones; None where the lips follow the sound alone, of which none are known
    """

    bundle: SpeakerBundle
    performance: Performance
    voice: str
    settings: SpeakSettings
    spoken: Timings | None = None

    @property
    def rate(self) -> float:
        """Frame rate in Hz: that of the recorded frames."""
        return self.bundle.background.rate

    @property
    def seconds(self) -> float:
        """Duration."""
        return self.performance.seconds

    @property
    def audio_rate(self) -> int:
        """Sample rate of the sound in Hz."""
        return self.performance.audio_rate

    @property
    def sound(self) -> np.ndarray:
        """All of the sound, (n,) float32 in [-1, 1], mono."""
        return np.concatenate(list(self.performance.sound()))

    @property
    def parameters(self) -> np.ndarray:
        """Parameters of the visual coding, (T, N) float32 at the rate of the model."""
        return np.asarray(self.performance.appearance[: len(self.performance.appearance)])

    @property
    def timings(self) -> dict | None:
        """Words, phones and visemes with their times in the video (docs/speaking.md); None: the lips follow the sound
        alone, of which none are known."""
        if self.spoken is None:
            return None
        return self.spoken.data(self.performance.text, self.rate, frames_of(self.performance, self.rate))

    def __iter__(self) -> Iterator[np.ndarray]:
        """The frames, (height, width, 3) uint8 RGB, one at a time; height and width are even."""
        return speaking_frames(self.performance.appearance, self.bundle, self.settings, self.performance.rate)

    def save(
        self,
        path: str | Path | None = None,
        *,
        size: tuple[int, int] | int | None = None,
        frames: str | Path | None = None,
        timings: str | Path | None = None,
    ) -> Path | None:
        """Write a video with its sound, and metadata that say that it is synthetic; returns its path.

        Nothing is written if any of it fails.

        Parameters
        ----------
        path : ends in ``.mp4`` or ``.mov`` (H.264 and AAC), or ``.webm`` (VP9 and Opus); None: no video
        size : (width, height) in pixels, or a height; None: the size of the recordings
        frames : folder for the frames as numbered PNGs and ``sound.wav``; an existing one is replaced. None: no PNGs
        timings : file for :attr:`timings` as JSON

        Raises
        ------
        SettingError
            There is nothing to write; the name has another suffix; the size is odd, too small or too large; timings are
            not known.
        StorageError
            A file cannot be written.
        """
        if path is None and frames is None:
            raise SettingError("there is nothing to write; give the path of a video, or a folder for frames.")
        path = None if path is None else Path(path)
        if path is not None:
            check_video_name(path, shortened(path))
        wanted = size_of(_checked(size), self.bundle.background.size)
        if timings is not None and self.spoken is None:
            raise SettingError(f"timings={shortened(timings)}: the lips follow the sound alone, no words are known.")
        with ExitStack() as made:
            file = None if timings is None else made.enter_context(replacing(timings))
            speak(path, self.performance, self.bundle, self.voice, self.settings, size=wanted, frames_folder=frames)
            if file is not None:
                self.spoken.save(file, self.performance.text, self.rate, frames_of(self.performance, self.rate))
        return path

    def mp4(self) -> bytes:
        """The same file as bytes, for the answer to a request."""
        with TemporaryDirectory(prefix="visualspeech.") as folder:
            return self.save(Path(folder, "said.mp4")).read_bytes()


@dataclass(frozen=True)
class Speaker:
    """A speaker of a finished run: ``Speaker.load(folder).say("Hello.").save("hello.mp4")``.

    It is loaded once and can say any number of texts, one call each. A label in every frame and the metadata of the
    file say that what is shown is synthetic.

    Parameters
    ----------
    bundle : models, face at rest and recorded frames
    folder : that it was loaded from
    """

    bundle: SpeakerBundle
    folder: Path

    @classmethod
    def load(cls, folder: str | Path) -> "Speaker":
        """The speaker in a folder that the workflow's target ``speaker`` has written.

        Raises
        ------
        StorageError
            The folder is no speaker, or a part is missing or damaged.
        DataError
            A part was changed or replaced.
        """
        return cls(SpeakerBundle.load(folder), Path(folder))

    def before(self, background: str | Path) -> "Speaker":
        """The speaker before another background.

        Parameters
        ----------
        background : name of one recording of the own background, or a folder that ``visualspeech background`` has
            written; a name with a separator, and one that is a folder, is a folder

        Raises
        ------
        SettingError
            There is no such recording; the message lists them.
        StorageError
            The folder is no background, or is damaged.
        DataError
            It was prepared for another speaker.
        """
        folder = background_folder(background)
        if folder is None:
            return replace(self, bundle=only_recording(self.bundle, str(background)))
        return replace(self, bundle=load_background(self.bundle, self.folder, folder))

    @property
    def consent(self) -> str:
        """Whose face it is, and by what permission."""
        return self.bundle.consent

    def follows_sound(self, text: str | None) -> bool:
        """Whether the lips follow the sound of a recording alone, given with this text or with none."""
        return self._for_recording(text).reads_sound_alone

    def say(
        self,
        text: str,
        *,
        voice: str = "en-us",
        speed: int = 150,
        pitch: int = 45,
        seed: int = 0,
        label: bool = True,
    ) -> Said:
        """The speaker saying a text with a synthetic voice.

        Parameters
        ----------
        text : English text of any length
        voice : English voice of eSpeak NG
        speed : words per minute, 80 to 450
        pitch : 0 to 100
        seed : of the order of the recorded frames
        label : whether each frame has the small label ``synthetic``

        Raises
        ------
        SettingError
            There is no word to pronounce, no such voice, or a value is out of range.
        """
        check_pronounceable(text)
        settings = VoiceSettings(voice, speed, pitch)
        spoken = speak_text(text, settings, self.bundle.shares, self.bundle.pronunciation)
        return self._said(self.bundle, spoken, f"synthetic (eSpeak NG, {voice})", seed, label)

    def say_recording(
        self, recording: str | Path, text: str | None = None, *, seed: int = 0, label: bool = True
    ) -> Said:
        """The speaker saying what is said in a recording, with the recorded voice.

        Parameters
        ----------
        recording : path of a sound or video file
        text : what is said in it; None: the lips follow the sound, or recognised phones where no model reads sound
        seed, label : as of :meth:`say`

        Raises
        ------
        SettingError
            The text is empty.
        RejectedUtterance
            The recording cannot be read, there is no speech in it, or the text is not what is said.
        """
        bundle = self._for_recording(text)
        rate, alone = bundle.trained.rate, bundle.reads_sound_alone
        if alone:
            log.info("the lips follow the sound of the recording (model %s)", bundle.model)
            spoken = speak_sound(recording, rate, text or "")
        else:
            if text is None:
                log.info("the lips follow recognised phones; for better ones, give its text")
            listens = "audio" in needs_of_model(bundle.trained)
            lexicon = bundle.lexicon()
            spoken = speak_recording(recording, text, rate, lexicon, shares=bundle.shares, with_sound=listens)
        with named(recording):
            return self._said(bundle, spoken, f"recording {Path(recording).name}, as given", seed, label, not alone)

    def _for_recording(self, text: str | None) -> SpeakerBundle:
        return self.bundle.for_recordings() if text is None else self.bundle

    def _said(self, bundle: SpeakerBundle, spoken, voice: str, seed: int, label: bool, timed: bool = True) -> Said:
        if not (isinstance(seed, int) and 0 <= seed <= MAX_SEED):
            raise SettingError(f"seed={shortened(seed)}: give a number from 0 to {MAX_SEED}.")
        settings = SpeakSettings(label=label, walk=WalkSettings(seed=seed))
        timings = Timings()
        performance = perform(spoken, bundle.trained, bundle.rest, timings=timings)
        return Said(bundle, performance, voice, settings, timings if timed else None)


def _checked(size: tuple[int, int] | int | None) -> tuple[int, int] | int | None:
    """The size of a video as given; raises SettingError unless it is one."""
    if size is None:
        return None
    sides = size if isinstance(size, tuple | list) else (size,)
    given = f"size={shortened(size)}"
    if len(sides) > 2 or not all(isinstance(side, int) for side in sides):
        raise SettingError(f"{given}: give (width, height) in pixels, or a height.")
    check_sides(sides, given)
    return tuple(sides) if len(sides) == 2 else sides[0]
