"""The console command ``visualspeech``: synthesises a video in which a speaker of a finished run says a text.

Errors are reported in one sentence. The exit status is 2 if the command line must be changed, 130 if the command was
interrupted (143 or 129 if it was told to end by SIGTERM or SIGHUP), and 1 for any other error.
"""

import argparse
import logging
import sys
from collections.abc import Sequence
from pathlib import Path

from visualspeech.errors import RejectedUtterance, SettingError, VisualSpeechError
from visualspeech.interruption import stoppable
from visualspeech.jobs import log

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
        with stoppable(_say_stopped):
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


def _say_stopped(reason: str) -> None:
    print("visualspeech: stopped; nothing was written.", file=sys.stderr, flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="visualspeech", description="Talking heads of recorded speakers.")
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
    speak.set_defaults(run=_speak)
    return parser


def _speak(given: argparse.Namespace) -> None:
    from visualspeech.speech.sentences import check_pronounceable
    from visualspeech.storage.files import check_writable

    text = _text(given)
    if given.output.suffix.lower() != ".mp4":
        raise SettingError(f"--output {given.output}: videos are written as MP4; give a name that ends in .mp4.")
    if given.output.is_dir():
        raise SettingError(f"--output {given.output} is a folder; give the name of the video file.")
    if given.seed < 0:
        raise SettingError(f"--seed {given.seed}: give a number of 0 or more.")
    check_writable(given.output)
    if text is not None:
        check_pronounceable(text)  # before anything is loaded
    from visualspeech.animation.bundle import SpeakerBundle
    from visualspeech.animation.performance import perform
    from visualspeech.animation.speaking import speak
    from visualspeech.animation.speaking_settings import SpeakSettings
    from visualspeech.animation.walk import WalkSettings
    from visualspeech.speech.spoken import speak_recording, speak_text
    from visualspeech.speech.spoken_settings import VoiceSettings

    bundle = SpeakerBundle.load(given.model)
    if given.audio:
        if text is None:
            log.info("the lips follow recognised phones; for better ones, give what is said with --text")
        spoken = speak_recording(given.audio, text, bundle.trained.rate, shares=bundle.shares)
        voice = f"recording {given.audio.name}, as given"
    else:
        settings = VoiceSettings(given.voice, given.speed, given.pitch)
        spoken = speak_text(text, settings, bundle.shares)
        voice = f"synthetic (eSpeak NG, {given.voice})"
    settings = SpeakSettings(label=not given.no_label, walk=WalkSettings(seed=given.seed))
    performance = perform(spoken, bundle.trained, bundle.rest)
    log.info("%.1f s of speech; rendering", performance.seconds)
    speak(given.output, performance, bundle, voice, settings)


def _text(given: argparse.Namespace) -> str | None:
    if given.text is not None and given.text_file is not None:
        raise SettingError("--text and --text-file are both given; give one of them.")
    if given.text is not None:
        return given.text
    if given.text_file is not None:
        try:
            if str(given.text_file) == "-":
                return sys.stdin.read()
            return given.text_file.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise SettingError(f"cannot read --text-file {given.text_file}: {reason}.") from error
    if given.audio is not None:
        return None
    raise SettingError("there is nothing to say; give --text, --text-file or --audio.")


if __name__ == "__main__":
    sys.exit(main())
