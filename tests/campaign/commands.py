"""Command lines of ``visualspeech speak``: each makes a video, or ends with a status and a sentence and no file."""

import contextlib
import io
import os
import random
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import soundfile

from tests.campaign.results import Result, refused, used
from tests.unit.animation import speakers
from visualspeech.cli import main


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of command lines most of which are wrong in one place or two."""
    results = []
    for number in range(count):
        here = folder / f"command{number}"
        here.mkdir()
        results.append(_attempt(here, random.Random(f"commands {seed} {number}")))
    return results


@cache
def _speaker() -> Path:
    """A small speaker, made once per process."""
    return speakers.make(Path(mkdtemp(prefix="visualspeech.campaign.")) / "speaker")


def _attempt(here: Path, rng: random.Random) -> Result:
    given = {"--model": str(_speaker()), "--text": "A map.", "-o": str(here / "said.mp4")}
    inputs = _inputs(here, rng)
    for option, value in rng.sample(list(_wrong(here, inputs, rng)), rng.choice([0, 1, 1, 1, 1, 2, 2])):
        if option in ("--audio", "--text-file"):
            given.pop("--text", None)
        given[option] = value
    arguments = [word for pair in given.items() for word in pair]
    case = " ".join(word if len(word) < 60 else f"{word[:20]}... ({len(word)} characters)" for word in arguments)
    case = case.replace(str(here), ".").replace(str(_speaker()), "SPEAKER").encode("ascii", "backslashreplace").decode()
    before = _contents(here)
    status, said = _told(arguments)
    lost = [path for path, content in before.items() if _contents(here).get(path) != content]
    if lost:
        return Result(case, bool(status), said, f"an input was changed: {', '.join(lost)}")
    new = sorted(set(_contents(here)) - set(before))
    if status == 0:
        return used(case, said, "" if len(new) == 1 else f"it left {new}")
    if new:
        return Result(case, True, said, f"status {status}, but it left {new}")
    if status not in (1, 2):
        return Result(case, True, said, f"status {status}: {said[-300:]}")
    names = [*given, "text", "word", "speaker", *(str(value)[:5] for value in given.values() if value)]
    return refused(case, said, names)


def _inputs(here: Path, rng: random.Random) -> dict[str, str]:
    """Files that a command line might be given."""
    files = {name: here / name for name in ("tone.wav", "noise.wav", "short.wav", "text.txt", "binary.bin", "empty")}
    time = np.arange(8000)
    soundfile.write(files["tone.wav"], 0.3 * np.sin(time / 5), 16_000)
    soundfile.write(files["noise.wav"], np.random.default_rng(rng.randrange(99)).normal(0, 0.2, 16_000), 16_000)
    soundfile.write(files["short.wav"], np.full(16, 0.1), 16_000)
    files["text.txt"].write_text("A map.")
    files["binary.bin"].write_bytes(rng.randbytes(3000))
    files["empty"].touch()
    (here / "folder").mkdir()
    (here / "link.wav").symlink_to(files["tone.wav"])
    return {**{name: str(path) for name, path in files.items()}, "folder": str(here / "folder")}


def _wrong(here: Path, inputs: dict[str, str], rng: random.Random) -> Iterator[tuple[str, str]]:
    """Options with values that a user or an enemy may give."""
    paths = [*inputs.values(), str(here / "nowhere"), "", "http://127.0.0.1:9/a.wav", "concat:a|b", "-", "/dev/zero",
             "/dev/null", "~nobodyhere/x", "a\udce9b", "a" * 300, str(_speaker() / "model.safetensors")]  # fmt: skip
    texts = ["", " ", "?!", "\ud800", "a" * 100_000, "\0", "\u202eabc", "\U0001f600", "你好", "\x1b[31m", "1e999"]
    outputs = [str(here / f"{'o' * size}.mp4") for size in (230, 245, 252, 300)]
    outputs += [str(here / "x.avi"), str(here / "folder"), str(here / "text.txt" / "x.mp4"), "/proc/x.mp4", "/dev/null"]
    numbers = ["-1", "0", "79", "451", "101", "1e3", "nan", "9" * 24, "", "x", "1.5"]
    yield "--model", rng.choice(paths)
    yield "--text", rng.choice(texts)
    yield "--text-file", rng.choice(paths)
    yield "--audio", rng.choice([path for path in paths if path])  # an empty path is the folder "."
    yield "-o", rng.choice(outputs)
    for option in ("--speed", "--pitch", "--seed"):
        yield option, rng.choice(numbers)
    yield "--voice", rng.choice(["", "martian", "en-us", "../../etc/passwd", "en-us" * 100, "\0", "de"])


def _told(arguments: list[str]) -> tuple[int, str]:
    """Exit status of a command line, and what it said on standard error."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        try:
            status = main(["speak", *arguments])
        except SystemExit as left:
            status = int(left.code or 0)
    # argparse puts the usage before its sentence.
    return status, said.getvalue().rpartition("visualspeech speak: ")[2] if status == 2 else said.getvalue()


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not os.path.islink(path)
    }
