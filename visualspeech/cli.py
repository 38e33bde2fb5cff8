"""The console command ``visualspeech``: a speaker says a text, one's own backgrounds, export of results, viewing tests.

Errors are reported in one sentence. The exit status is 2 if the command line must be changed, 130 if the command was
interrupted (143 or 129 if it was told to end by SIGTERM or SIGHUP), and 1 for any other error.
"""

import argparse
import errno
import logging
import operator
import os
import stat
import sys
from collections.abc import Sequence
from pathlib import Path

from visualspeech.api.command import add_export
from visualspeech.errors import CorpusError, SettingError, VisualSpeechError
from visualspeech.fields import MAX_SEED, shortened
from visualspeech.interruption import stoppable
from visualspeech.jobs import log
from visualspeech.study.command import add_study

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
        print(f"visualspeech: {error}", file=sys.stderr)
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
    parser.set_defaults(stopped=_say_stopped)
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
    speak.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="the video to write: .mp4 or .mov (H.264 and AAC), .webm (VP9 and Opus)",
    )  # fmt: skip
    speak.add_argument("--frames", type=Path, metavar="DIR", help="write numbered PNGs and sound.wav into a new folder")
    speak.add_argument(
        "--timings", type=Path, metavar="FILE.json", help="write words, phones and visemes with their times"
    )
    speak.add_argument(
        "--size", metavar="WxH|H", help="size of the video in pixels, or its height (default: that of the recordings)"
    )
    speak.add_argument(
        "--background", metavar="NAME|FOLDER",
        help="a recording of the speaker's background, or a folder that `visualspeech background` wrote",
    )  # fmt: skip
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
    background = commands.add_parser(
        "background",
        help="prepare clips of a speaker as a background",
        description="Track and check clips of a speaker, and write them as a background for `speak --background`.",
    )
    background.add_argument(
        "--model", required=True, type=Path, metavar="FOLDER",
        help="the speaker: a folder written by the workflow's target `speaker`",
    )  # fmt: skip
    background.add_argument(
        "--video", required=True, nargs="+", type=Path, metavar="FILE", help="clips of the speaker, of one camera"
    )
    background.add_argument(
        "--landmarks", type=Path, metavar="FOLDER",
        help="landmarks of the clips as CSV files of OpenFace, if the speaker was made with such",
    )  # fmt: skip
    background.add_argument(
        "--tracker", metavar="MODULE:CLASS",
        help="a tracker of your own, in the working folder or installed, if the speaker was made with it; it is run",
    )  # fmt: skip
    background.add_argument("-o", "--output", required=True, type=Path, metavar="FOLDER", help="the folder to write")
    background.add_argument(
        "--start", type=float, default=0.0, metavar="SECONDS", help="beginning of the part of each clip that is used"
    )
    background.add_argument("--end", type=float, default=0.0, metavar="SECONDS", help="its end; 0 for that of the clip")
    background.add_argument("--quiet", action="store_true", help="no progress lines")
    background.add_argument("--debug", action="store_true", help=argparse.SUPPRESS)
    background.set_defaults(run=_background)
    add_export(commands)
    add_study(commands)
    return parser


def _speak(given: argparse.Namespace) -> None:
    from visualspeech.speech.sentences import check_pronounceable
    from visualspeech.speech.spoken_settings import VoiceSettings

    text = _text(given)
    if not 0 <= given.seed <= MAX_SEED:
        raise SettingError(f"--seed {shortened(given.seed)}: give a number from 0 to {MAX_SEED}.")
    VoiceSettings(given.voice, given.speed, given.pitch)  # checks them
    wanted = None if given.size is None else _size(given.size)
    _check_model(given.model)
    if text is not None:
        check_pronounceable(text)  # before anything is loaded
    if given.audio is not None:
        _check_media(given.audio, "sound or video file")
    _check_outputs(given)
    from visualspeech.animation.frame_files import size_of
    from visualspeech.api.speaker import Speaker

    speaker = Speaker.load(given.model)
    if given.background:
        speaker = speaker.before(given.background)
    recorded = speaker.bundle.background.size
    if wanted is not None and any(map(operator.gt, size_of(wanted, recorded), recorded)):
        shown = " by ".join(map(str, recorded))
        log.warning("--size is larger than the recorded %s pixels; larger frames show no more detail", shown)
    options = {"seed": given.seed, "label": not given.no_label}
    if given.audio is None:
        said = speaker.say(text, voice=given.voice, speed=given.speed, pitch=given.pitch, **options)
    elif given.timings is not None and speaker.follows_sound(text):
        raise SettingError(
            "--timings: the lips follow the sound alone, of which no words and phones are known; give what is said "
            "with --text to a speaker whose model reads text, or leave --timings out."
        )
    else:
        said = speaker.say_recording(given.audio, text, **options)
    log.info("%.1f s of speech; rendering", said.seconds)
    said.save(given.output, size=wanted, frames=given.frames, timings=given.timings)


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


def _check_model(folder: Path) -> None:
    if not os.path.isdir(folder):
        what = "is a file" if os.path.isfile(folder) else "does not exist"
        raise SettingError(f"--model {shortened(folder)} {what}; give the folder that holds speaker.json.")


def _check_media(path: Path, kind: str) -> None:
    """Check that a recording is a file that can be read; addresses of other kinds are never opened."""
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
        if regular:
            path.open("rb").close()
    except OSError as error:
        missing = error.errno in (errno.ENOENT, errno.ENOTDIR)
        reason = "the file does not exist" if missing else f"cannot be read ({error.strerror})"
        raise _refused(path, reason, kind) from error
    if not regular:
        raise _refused(path, "this is not a regular file", kind)


def _refused(path: Path, reason: str, kind: str) -> CorpusError:
    return CorpusError(f"{shortened(path)}: {reason}. Give the path of a {kind}.")


def _check_outputs(given: argparse.Namespace) -> None:
    """Check, before anything is loaded, that every output can be written and replaces nothing that is needed.

    Raises
    ------
    SettingError
        Another name must be given.
    StorageError
        A path cannot be written.
    """
    from visualspeech.animation.command_paths import background_folder, check_outputs
    from visualspeech.animation.frame_files import check_video_name

    if given.output is None and given.frames is None:
        raise SettingError("there is nothing to write; give --output, --frames or both.")
    if given.output is not None:
        check_video_name(given.output, f"--output {shortened(given.output)}")
    files = {"--output": given.output, "--timings": given.timings}
    inputs = {
        "--audio": given.audio,
        "--text-file": given.text_file,
        "--background": background_folder(given.background or ""),
    }
    check_outputs(
        {option: path for option, path in files.items() if path is not None},
        {} if given.frames is None else {"--frames": given.frames},
        {option: path for option, path in inputs.items() if path is not None},
        given.model,
    )


def _size(text: str) -> tuple[int, int] | int:
    """``--size``: width and height, or a height alone.

    Raises
    ------
    SettingError
        It is neither, odd, or too small or large.
    """
    from visualspeech.animation.frame_files import check_sides

    sides = text.lower().split("x")
    if len(sides) > 2 or not all(side.isascii() and side.isdecimal() and len(side) < 10 for side in sides):
        raise SettingError(f"--size {shortened(text)}: give WIDTHxHEIGHT, such as 640x480, or a height, such as 480.")
    numbers = [int(side) for side in sides]
    check_sides(numbers, f"--size {shortened(text)}")
    return (numbers[0], numbers[1]) if len(numbers) == 2 else numbers[0]


def _background(given: argparse.Namespace) -> None:
    from visualspeech.animation.command_paths import check_outputs

    _check_model(given.model)
    for path in given.video:
        _check_media(path, "video file")
    if not (0 <= given.start < 1e6 and (given.end == 0 or given.start < given.end < 1e6)):
        raise SettingError("--start and --end: give seconds from 0 on, the start before the end.")
    if given.landmarks is not None and not given.landmarks.is_dir():
        raise SettingError(f"--landmarks {shortened(given.landmarks)} is no folder; give the folder of the CSV files.")
    if given.landmarks is not None and given.tracker is not None:
        raise SettingError("--landmarks and --tracker are both given; give one of them.")
    inputs = {f"--video {path}": path for path in given.video}
    inputs |= {} if given.landmarks is None else {"--landmarks": given.landmarks}
    check_outputs({}, {"--output": given.output}, inputs, given.model)
    from visualspeech.animation.backgrounds import prepare_background

    settings, folder = _landmark_source(given)
    background = prepare_background(given.output, given.model, given.video, given.start, given.end, settings, folder)
    width, height = background.size
    log.info(
        "%s holds %d frames of %d by %d pixels at %g Hz; use it with `visualspeech speak --background %s`",
        given.output, len(background), width, height, background.rate, given.output,
    )  # fmt: skip


def _landmark_source(given: argparse.Namespace):
    """Settings of the landmarks of ``background``, and the folder in which a tracker of one's own lies."""
    from visualspeech.face.tracker import LandmarkSettings

    if given.landmarks is not None:
        return LandmarkSettings(source="csv", folder=str(given.landmarks)), ""
    if given.tracker is None:
        return LandmarkSettings(), ""
    module = given.tracker.partition(":")[0].partition(".")[0]
    here = Path(f"{module}.py").is_file() or Path(module).is_dir()
    return LandmarkSettings(tracker=given.tracker), str(Path.cwd()) if here else ""


if __name__ == "__main__":
    sys.exit(main())
