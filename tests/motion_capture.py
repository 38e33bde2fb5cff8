"""Small corpora of motion capture in the formats of their releases: a tree of IEMOCAP, folders of CSV files."""

import wave
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from tests.synthetic import hum

RATE = 120.0  # Hz, of IEMOCAP
#: Order of the markers in a file of the release.
MARKERS = (
    *(f"CH{n}" for n in range(1, 4)), *(f"FH{n}" for n in range(1, 4)), *(f"LC{n}" for n in range(1, 9)),
    *(f"RC{n}" for n in range(1, 9)), "LLID", "RLID", "MH", "MNOSE", "LNSTRL", "TNOSE", "RNSTRL",
    *(f"LBM{n}" for n in range(4)), *(f"RBM{n}" for n in range(4)), *(f"LBRO{n}" for n in range(1, 5)),
    *(f"RBRO{n}" for n in range(1, 5)), *(f"Mou{n}" for n in range(1, 9)), "LHD", "RHD",
)  # fmt: skip
#: Emotion of a turn -> what its three raters chose; each rater may name several.
RATINGS = {
    "neu": ("Neutral;", "Neutral;", "Neutral;"),
    "ang": ("Anger;", "Anger; Frustration;", "Anger;"),
    "sad": ("Sadness;", "Neutral;", "Sadness;"),
    "exc": ("Excited;", "Excited;", "Happiness;"),
    "xxx": ("Neutral;", "Anger;", "Sadness;"),
}
#: Columns of a CSV file of Live Link Face after ``Timecode`` and ``BlendShapeCount``.
LIVE_LINK = tuple(
    "EyeBlinkLeft EyeLookDownLeft EyeLookInLeft EyeLookOutLeft EyeLookUpLeft EyeSquintLeft EyeWideLeft EyeBlinkRight "
    "EyeLookDownRight EyeLookInRight EyeLookOutRight EyeLookUpRight EyeSquintRight EyeWideRight JawForward JawRight "
    "JawLeft JawOpen MouthClose MouthFunnel MouthPucker MouthRight MouthLeft MouthSmileLeft MouthSmileRight "
    "MouthFrownLeft MouthFrownRight MouthDimpleLeft MouthDimpleRight MouthStretchLeft MouthStretchRight "
    "MouthRollLower MouthRollUpper MouthShrugLower MouthShrugUpper MouthPressLeft MouthPressRight MouthLowerDownLeft "
    "MouthLowerDownRight MouthUpperUpLeft MouthUpperUpRight BrowDownLeft BrowDownRight BrowInnerUp BrowOuterUpLeft "
    "BrowOuterUpRight CheekPuff CheekSquintLeft CheekSquintRight NoseSneerLeft NoseSneerRight TongueOut HeadYaw "
    "HeadPitch HeadRoll LeftEyeYaw LeftEyePitch LeftEyeRoll RightEyeYaw RightEyePitch RightEyeRoll".split()
)


def write_wav(path: Path, seconds: float, pitch: float = 120.0) -> np.ndarray:
    """A voice-like sound at 16 kHz; returns its samples."""
    samples = hum(seconds, 16_000, pitch)
    path.parent.mkdir(parents=True, exist_ok=True)
    with wave.open(str(path), "wb") as out:
        out.setparams((1, 2, 16_000, 0, "NONE", ""))
        out.writeframes(np.round(samples * 32767).astype("<i2").tobytes())
    return samples


def moving(seconds: float, count: int, rate: float = RATE, seed: int = 0, size: float = 3.0) -> np.ndarray:
    """Coordinates of markers in mm that move with the syllables of :func:`tests.synthetic.hum`, (T, count, 3)."""
    random = np.random.default_rng(seed)
    times = np.arange(round(seconds * rate)) / rate
    syllables = np.maximum(np.sin(2 * np.pi * 4 * times), 0)
    slow = np.sin(2 * np.pi * (0.7 * times + random.random()))
    places = np.random.default_rng(7).normal(0, 60, (count, 3))
    along = np.random.default_rng(8).normal(0, 1, (2, count, 3))
    moved = size * (syllables[:, None, None] * along[0] + 0.3 * slow[:, None, None] * along[1])
    return places + moved + random.normal(0, 0.05, (len(times), count, 3))


def write_mocap(path: Path, points: np.ndarray, start: float = 6.2901, markers: Sequence[str] = MARKERS) -> None:
    """A file of ``MOCAP_rotated``: points (T, P, 3) in mm, NaN where a marker is occluded."""
    lines = ["Frame# Time " + " ".join(markers), "FrameNo. Time " + " ".join("X Y Z" for _ in markers)]
    first = int(np.ceil(start * RATE))
    for number, frame in enumerate(points, first):
        values = " ".join("NaN" if np.isnan(value) else f"{value:.5f}" for value in frame.ravel())
        lines.append(f"{number} {number / RATE:.5f} {values}")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def write_evaluation(path: Path, turns: Mapping[str, str]) -> None:
    """A file of ``EmoEvaluation``: turn -> its label; the raters choose accordingly."""
    lines = ["% [START_TIME - END_TIME] TURN_NAME EMOTION [V, A, D]", ""]
    for number, (turn, label) in enumerate(turns.items()):
        start = 6.2901 + 3 * number
        lines.append(f"[{start:.4f} - {start + 1.9456:.4f}]\t{turn}\t{label}\t[2.5000, 2.5000, 2.5000]")
        lines += [f"C-E{rater}:\t{said}\t()" for rater, said in zip((2, 3, 4), RATINGS[label], strict=True)]
        lines += [f"C-{turn[5]}1:\tHappiness;\t()"]  # the actor's own opinion
        lines += ["A-E3:\tval 3; act 2; dom  2;\t()", ""]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines))


class IemocapTree:
    """A small tree of IEMOCAP: two actors per session, one recording each, and turns of both in every recording.

    ``labels`` are the emotions of the turns of each actor with markers in their order; the last turn of a recording is
    missing in its emotion file if ``unrated``. Every second turn has a gap of 0.1 s in one marker.
    """

    def __init__(self, root: Path, sessions=(1, 2), labels=tuple(RATINGS), seconds=1.6, unrated=False) -> None:
        self.root, self.seconds = Path(root), seconds
        self.turns: dict[str, str] = {}  # turn -> label, of the actors with markers
        for session in sessions:
            for actor, style in (("F", "impro01"), ("M", "script01_1")):
                self._recording(session, actor, style, list(labels), unrated)

    def folder(self, turn: str, *parts: str) -> Path:
        """A folder of the session of a turn or recording."""
        return self.root.joinpath(f"Session{int(turn[3:5])}", *parts)

    def motion(self, turn: str) -> Path:
        return self.folder(turn, "sentences", "MOCAP_rotated", turn.rpartition("_")[0], f"{turn}.txt")

    def sound(self, turn: str) -> Path:
        return self.folder(turn, "sentences", "wav", turn.rpartition("_")[0], f"{turn}.wav")

    def evaluation(self, turn: str) -> Path:
        return self.folder(turn, "dialog", "EmoEvaluation", f"{turn.rpartition('_')[0]}.txt")

    def transcription(self, turn: str) -> Path:
        return self.folder(turn, "dialog", "transcriptions", f"{turn.rpartition('_')[0]}.txt")

    def _recording(self, session: int, actor: str, style: str, labels: list[str], unrated: bool) -> None:
        dialog, other = f"Ses{session:02d}{actor}_{style}", "M" if actor == "F" else "F"
        rated = {}
        for number, label in enumerate(labels):
            for who in (actor, other):
                turn = f"{dialog}_{who}{number:03d}"
                write_wav(self.sound(turn), self.seconds, 110.0 if who == "M" else 190.0 + number)
                rated[turn] = label
            turn = f"{dialog}_{actor}{number:03d}"
            self.turns[turn] = label
            points = moving(self.seconds, len(MARKERS), seed=100 * session + number)
            if number % 2:
                points[40:52, MARKERS.index("Mou1")] = np.nan
            write_mocap(self.motion(turn), points, 6.2901 + 3 * number)
        if unrated:
            rated.pop(f"{dialog}_{actor}{len(labels) - 1:03d}")
        write_evaluation(self.evaluation(f"{dialog}_X"), rated)
        # Beside the evaluations lie those of single raters, in folders of their own.
        write_evaluation(self.evaluation(f"{dialog}_X").parent / "Categorical" / f"{dialog}_e2_cat.txt", rated)
        lines = [f"{turn} [{6 + 3 * n:08.4f}-{8 + 3 * n:08.4f}]: Excuse me, [LAUGHTER] number {n}."
                 for n, turn in enumerate(rated)]  # fmt: skip
        path = self.transcription(f"{dialog}_X")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n")


def write_csv(path: Path, times: Sequence, columns: Mapping[str, Sequence], time_name: str = "time") -> None:
    """A CSV file: times (numbers or texts) and the values of each column; NaN leaves a cell empty."""
    lines = [",".join([time_name, *columns])]
    for time, *values in zip(times, *columns.values(), strict=True):
        lines.append(",".join([str(time), *("" if np.isnan(value) else f"{value:.6g}" for value in values)]))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def marker_columns(names: Sequence[str], points: np.ndarray) -> dict[str, np.ndarray]:
    """Columns ``<name>_x``, ``_y`` and ``_z`` of points (T, P, 3)."""
    return {
        f"{name}_{axis}": points[:, marker, number]
        for marker, name in enumerate(names)
        for number, axis in enumerate("xyz")
    }


def timecodes(frames: int, rate: float = 60.0, start: float = 17 * 3600 + 32 * 60 + 4.9, count: int = 60) -> list[str]:
    """Timecodes as Live Link Face writes them: hours:minutes:seconds:frames.thousandths."""
    texts = []
    for frame in range(frames):
        seconds = (start + frame / rate) % 86_400
        whole = int(seconds + 1e-9)
        texts.append(f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}:{(seconds - whole) * count:06.3f}")
    return texts


def write_live_link(path: Path, seconds: float = 1.6, rate: float = 60.0, unseen: Sequence[int] = ()) -> np.ndarray:
    """A CSV file of Live Link Face; rows of ``unseen`` hold no face. Returns the values (T, 61)."""
    points = moving(seconds, len(LIVE_LINK), rate)[:, :, 0]
    values = 1 / (1 + np.exp(-(points - points.mean(axis=0))))
    lines = [",".join(["Timecode", "BlendShapeCount", *LIVE_LINK])]
    for row, code in enumerate(timecodes(len(values), rate)):
        seen = row not in unseen
        cells = [f"{value:.8f}" for value in values[row]] if seen else []
        lines.append(",".join([code, str(len(LIVE_LINK) if seen else 0), *cells]))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")
    return values
