"""The console command ``visualspeech``: videos in which a speaker of a finished run says a text, and viewing tests.

Errors are reported in one sentence. The exit status is 2 if the command line must be changed, 130 if the command was
interrupted (143 or 129 if it was told to end by SIGTERM or SIGHUP), and 1 for any other error.
"""

import argparse
import errno
import logging
import os
import stat
import sys
from collections.abc import Sequence
from pathlib import Path

from visualspeech.errors import RejectedUtterance, SettingError, VisualSpeechError
from visualspeech.fields import MAX_SEED, shortened
from visualspeech.interruption import stoppable
from visualspeech.jobs import log
from visualspeech.study.command import add_study

#: Bytes of a name and of a path.
MAX_NAME, MAX_PATH = 255, 4000

# torch, dlib and the media libraries are imported only when a command runs, so that help and errors appear at once.


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    given = _parser().parse_args(arguments)
    terminal = logging.StreamHandler(sys.stderr)
    terminal.setFormatter(logging.Formatter("%(message)s"))
    log.handlers[:] = [] if given.quiet else [terminal]
    log.setLevel(logging.INFO)
    log.propagate = False
    logging.raiseExceptions = False  # a closed terminal is no error
    try:
        with stoppable(lambda _: given.stopped()):
            given.run(given)
    except VisualSpeechError as error:
        message = str(error)
        if isinstance(error, RejectedUtterance):
            message = f"{given.audio}: {error.reason}. {error.remedy}".strip()
        print(f"visualspeech: {message}", file=sys.stderr)
        return 2 if isinstance(error, SettingError) else 1
    except MemoryError:
        print("visualspeech: out of memory. Give a shorter text, or a background of smaller frames.", file=sys.stderr)
        return 1
    except Exception as error:
        if given.debug:
            raise
        print(
            f"visualspeech: unexpected error: {error!r}. Run again with --debug and report the output.",
            file=sys.stderr,
        )
        return 1
    return 0


def _say_stopped() -> None:
    print("visualspeech: stopped; nothing was written.", file=sys.stderr, flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="visualspeech", description="Talking heads of recorded speakers, and viewing tests."
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    speak = commands.add_parser(
        "speak",
        help="make a speaker say a text",
        description="Write a video of a speaker who says a text, with a synthetic voice or with a given recording.",
    )
    speak.add_argument(
        "--model", required=True, type=Path, metavar="FOLDER",
        help="the speaker: a folder written by the workflow's target `speaker`",
    )  # fmt: skip
    speak.add_argument("--text", help="what to say; with --audio, what is said in the recording")
    speak.add_argument(
        "--text-file", type=Path, metavar="FILE", help="the same from a UTF-8 file (- for standard input)"
    )
    speak.add_argument("--audio", type=Path, metavar="FILE", help="a recording of speech that gives the voice")
    speak.add_argument("-o", "--output", required=True, type=Path, metavar="FILE.mp4", help="the video to write")
    speak.add_argument("--voice", default="en-us", help="English voice of eSpeak NG (default: %(default)s)")
    speak.add_argument("--speed", type=int, default=150, help="words per minute, 80 to 450 (default: %(default)s)")
    speak.add_argument("--pitch", type=int, default=45, help="0 to 100 (default: %(default)s)")
    speak.add_argument(
        "--seed", type=int, default=0, help="seed of the order of the background frames (default: %(default)s)"
    )
    speak.add_argument("--no-label", action="store_true", help="leave out the small label `synthetic` in the frames")
    speak.add_argument("--quiet", action="store_true", help="no progress lines")
    speak.add_argument("--debug", action="store_true", help=argparse.SUPPRESS)
    speak.set_defaults(run=_speak, stopped=_say_stopped)
    add_study(commands)
    return parser


def _speak(given: argparse.Namespace) -> None:
    from visualspeech.speech.sentences import check_pronounceable
    from visualspeech.speech.spoken_settings import VoiceSettings

    text = _text(given)
    if not 0 <= given.seed <= MAX_SEED:
        raise SettingError(f"--seed {shortened(given.seed)}: give a number from 0 to {MAX_SEED}.")
    voice_settings = VoiceSettings(given.voice, given.speed, given.pitch)
    if not os.path.isdir(given.model):
        what = "is a file" if os.path.isfile(given.model) else "does not exist"
        raise SettingError(f"--model {shortened(given.model)} {what}; give the folder that holds speaker.json.")
    if text is not None:
        check_pronounceable(text)  # before anything is loaded
    _check_audio(given.audio)
    _check_output(given)
    from visualspeech.animation.bundle import SpeakerBundle
    from visualspeech.animation.performance import perform
    from visualspeech.animation.speaking import speak
    from visualspeech.animation.speaking_settings import SpeakSettings
    from visualspeech.animation.walk import WalkSettings
    from visualspeech.models.inventory import needs_of_model
    from visualspeech.speech.spoken import speak_recording, speak_sound, speak_text

    bundle = SpeakerBundle.load(given.model)
    if given.audio:
        bundle = bundle.for_recordings() if text is None else bundle
        rate = bundle.trained.rate
        if bundle.reads_sound_alone:
            log.info("the lips follow the sound of the recording (model %s)", bundle.model)
            spoken = speak_sound(given.audio, rate, text or "")
        else:
            if text is None:
                log.info("the lips follow recognised phones; for better ones, give what is said with --text")
            listens = "audio" in needs_of_model(bundle.trained)
            spoken = speak_recording(given.audio, text, rate, shares=bundle.shares, with_sound=listens)
        voice = f"recording {given.audio.name}, as given"
    else:
        spoken = speak_text(text, voice_settings, bundle.shares)
        voice = f"synthetic (eSpeak NG, {given.voice})"
    settings = SpeakSettings(label=not given.no_label, walk=WalkSettings(seed=given.seed))
    performance = perform(spoken, bundle.trained, bundle.rest)
    log.info("%.1f s of speech; rendering", performance.seconds)
    speak(given.output, performance, bundle, voice, settings)


def _text(given: argparse.Namespace) -> str | None:
    from visualspeech.speech.sentences import decoded, read_text

    if given.text is not None and given.text_file is not None:
        raise SettingError("--text and --text-file are both given; give one of them.")
    if given.text is not None:
        return given.text
    if given.text_file is not None:
        try:
            return decoded(sys.stdin.buffer) if str(given.text_file) == "-" else read_text(given.text_file)
        except SettingError as error:
            raise SettingError(f"cannot read --text-file {given.text_file}: {error}") from error
    if given.audio is not None:
        return None
    raise SettingError("there is nothing to say; give --text, --text-file or --audio.")


def _check_audio(path: Path | None) -> None:
    """Check that a recording is a file that can be read; addresses of other kinds are never opened."""
    if path is None:
        return
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
        if regular:
            path.open("rb").close()
    except OSError as error:
        missing = error.errno in (errno.ENOENT, errno.ENOTDIR)
        reason = "the file does not exist" if missing else f"cannot be read ({error.strerror})"
        raise RejectedUtterance(reason, "Give the path of a sound or video file.") from error
    if not regular:
        raise RejectedUtterance("this is not a regular file", "Give the path of a sound or video file.")


def _check_output(given: argparse.Namespace) -> None:
    """Check that the video can be written, and that it replaces nothing but a file that is no input.

    Raises
    ------
    SettingError
        Another name must be given.
    StorageError
        The file cannot be written.
    """
    from visualspeech.storage.files import check_writable

    path = given.output
    if path.suffix.lower() != ".mp4":
        raise SettingError(f"--output {path}: videos are written as MP4; give a name that ends in .mp4.")
    size = len(os.fsencode(path.name))
    if size > MAX_NAME:
        raise SettingError(f"--output: the name of the file has {size} bytes; give one of at most {MAX_NAME}.")
    if any(len(os.fsencode(part)) > MAX_NAME for part in path.parts) or len(os.fsencode(path.absolute())) > MAX_PATH:
        raise SettingError(
            f"--output: a path has at most {MAX_PATH} bytes, and the name of a folder at most {MAX_NAME}; give a "
            "shorter one."
        )
    if any("\ud800" <= character <= "\udfff" for character in str(path)):
        raise SettingError(f"--output {shortened(path)}: the path is not UTF-8 text; give another.")
    if path.is_dir():
        raise SettingError(f"--output {path} is a folder; give the name of the video file.")
    if path.exists() and not path.is_file():
        raise SettingError(f"--output {path} is a device or pipe; give the name of a file.")
    inputs = {"--audio": given.audio, "--text-file": given.text_file}
    same = next((option for option, one in inputs.items() if one is not None and _is_same(path, one)), None)
    if same:
        raise SettingError(f"--output {path} is the file of {same}, which would be replaced; give another name.")
    if _is_part(path, given.model):
        raise SettingError(f"--output {path} is a part of the speaker {given.model}; give another name.")
    check_writable(path)


def _is_same(path: Path, other: Path) -> bool:
    """Whether two paths lead to one file, by whatever links and spellings."""
    if os.path.realpath(path) == os.path.realpath(other):
        return True
    try:
        return os.path.samefile(path, other)
    except OSError:
        return False


def _is_part(path: Path, folder: Path) -> bool:
    """Whether a file lies in a folder, also by a link, or is one of its files."""
    try:
        return os.path.realpath(folder) in map(os.path.realpath, path.absolute().parents) or any(
            _is_same(path, one) for one in folder.iterdir()
        )
    except OSError:  # there is no such folder
        return False


if __name__ == "__main__":
    sys.exit(main())
