"""Landmark trackers as users write them, for tests; some are wrong in one way each."""

import numpy as np

NOT_A_CLASS = 3


class Corner:
    """All points at (n, n) in the nth frame; remembers what it was told."""

    videos: list = []
    numbers: list = []

    def __init__(self, settings, video):
        self.videos.append(video)
        self.count = 0

    def next(self, frame, number):
        self.numbers.append(number)
        self.count += 1
        return np.full((68, 2), float(self.count))


class Oscillating:
    """Points that move at 1 Hz."""

    def __init__(self, settings, video):
        self.rate = video.rate

    def next(self, frame, number):
        return np.full((68, 2), 50 * np.sin(2 * np.pi * (number + 0.5) / self.rate))

    def faces(self):
        return 1


class Blind(Corner):
    def next(self, frame, number):
        return None


class Remarking(Corner):
    def faces(self):
        return 3

    def warnings(self):
        return ["the light was poor"]


class Returning(Corner):
    """Returns what a test sets."""

    points = None

    def next(self, frame, number):
        return self.points


class OldStyle:
    def __init__(self, settings):
        pass


class NoNext:
    def __init__(self, settings, video):
        pass


class OldNext(NoNext):
    def next(self, frame):
        return None


class Failing(Corner):
    def next(self, frame, number):
        raise ZeroDivisionError("division by zero")
