"""A strict reader of FAP 2.1 text files, written from the standard and not from the writer.

ISO/IEC 14496-2, annex C; the text format is that of the MPEG-4 reference software: a header ``2.1 name fps frames``,
and per frame a line of 68 masks and a line of the frame's number and the values of the unmasked parameters. Parameter 1
(viseme) has four numbers, parameter 2 (expression) six, all others one. Values outside the range that the bit stream
can code are refused.
"""

import re
from dataclasses import dataclass

#: Numbers of the parameters without negative values: open_jaw, thrust_jaw, lift_l_cheek, lift_r_cheek, tongue_roll.
UNSIGNED = {3, 14, 41, 42, 47}
#: Quantiser step and largest quantised value of the parameters, in runs of numbers (table C.1).
RUNS = (
    ((3, 3), 4, 1080), ((4, 4), 2, 600), ((5, 5), 2, 1860), ((6, 9), 2, 600), ((10, 11), 2, 1860), ((12, 13), 2, 600),
    ((14, 14), 1, 600), ((15, 17), 1, 1080), ((18, 18), 1, 420), ((19, 20), 1, 1080), ((21, 22), 1, 600),
    ((23, 24), 128, 1200), ((25, 26), 128, 900), ((27, 28), 1, 600), ((29, 30), 1, 420), ((31, 36), 2, 900),
    ((37, 38), 1, 900), ((39, 40), 2, 900), ((41, 42), 2, 600), ((43, 46), 1, 1080), ((47, 47), 512, 300),
    ((48, 50), 170, 1860), ((51, 51), 2, 600), ((52, 52), 2, 1860), ((53, 56), 2, 600), ((57, 58), 2, 1860),
    ((59, 60), 2, 600), ((61, 62), 1, 540), ((63, 63), 1, 680), ((64, 68), 1, 900),
)  # fmt: skip
LIMITS = {number: step * most for (first, last), step, most in RUNS for number in range(first, last + 1)}
NUMBERS = {1: 4, 2: 6}
_INTEGER = re.compile(r"-?(0|[1-9][0-9]*)")


class FapError(ValueError):
    """The text is no FAP 2.1 file; the message names the line."""


@dataclass(frozen=True)
class FapFile:
    """An animation: ``frames[i]`` maps the number of a parameter to its numbers in frame i."""

    name: str
    rate: int
    frames: list[dict[int, tuple[int, ...]]]


def read_fap(text: str) -> FapFile:
    """Read the text of a file; raises FapError for the least deviation from the format."""
    if not text.endswith("\n") or "\r" in text:
        raise FapError("lines must end with a line feed, the last one too")
    lines = text[:-1].split("\n")
    head = lines[0].split(" ")
    if len(head) != 4 or head[0] != "2.1" or not re.fullmatch(r"\S+", head[1]):
        raise FapError("line 1: the header must be '2.1 name fps frames'")
    rate, count = (_integer(one, 1) for one in head[2:])
    if rate < 1 or count < 1:
        raise FapError("line 1: frame rate and number of frames must be positive")
    if len(lines) != 1 + 2 * count:
        raise FapError(f"{count} frames need {1 + 2 * count} lines, there are {len(lines)}")
    return FapFile(head[1], rate, [_frame(lines, index) for index in range(count)])


def _frame(lines: list[str], index: int) -> dict[int, tuple[int, ...]]:
    at = 2 + 2 * index
    mask = lines[at - 1].split(" ")
    if len(mask) != 68 or not set(mask) <= {"0", "1"}:
        raise FapError(f"line {at}: there must be 68 masks, each 0 or 1")
    numbers = [_integer(one, at + 1) for one in lines[at].split(" ")]
    if numbers[0] != index:
        raise FapError(f"line {at + 1}: frame {numbers[0]} where {index} follows")
    held = [number for number, one in enumerate(mask, start=1) if one == "1"]
    if len(numbers) - 1 != sum(NUMBERS.get(number, 1) for number in held):
        raise FapError(f"line {at + 1}: the number of values differs from the masks")
    values, position = {}, 1
    for number in held:
        size = NUMBERS.get(number, 1)
        values[number] = tuple(numbers[position : position + size])
        position += size
        if number > 2:
            least = 0 if number in UNSIGNED else -LIMITS[number]
            if not least <= values[number][0] <= LIMITS[number]:
                raise FapError(f"line {at + 1}: parameter {number} is {values[number][0]}, outside its range")
    return values


def _integer(text: str, line: int) -> int:
    if not _INTEGER.fullmatch(text):
        raise FapError(f"line {line}: {text!r} is no integer")
    return int(text)
