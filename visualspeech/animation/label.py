"""Text in frames: titles above panels, and the small label of synthetic frames."""

import numpy as np

_FONT = 0  # cv2.FONT_HERSHEY_SIMPLEX; named here so that cv2 is imported only where text is drawn


def title_height(height: int) -> int:
    """Height in pixels (even) of the title bar over frames of the given height."""
    return 2 * max(11, round(0.035 * height))


def title_bar(titles: list[str], widths: list[int], height: int) -> np.ndarray:
    """A dark bar with one centred title over each panel, (height, sum of widths, 3) uint8."""
    bars = []
    for title, width in zip(titles, widths, strict=True):
        bar = np.full((height, width, 3), 32, np.uint8)
        text, size, scale, thickness = _fitted(title, 0.6 * height, 0.95 * width)
        position = (int((width - size[0]) / 2), int((height + size[1]) / 2))
        bars.append(_with_text(bar, text, position, scale, thickness, 235))
    return np.hstack(bars)


def labelled(frame: np.ndarray, text: str) -> np.ndarray:
    """A copy of a frame (height, width, 3) uint8 RGB with a small label in its lower right corner."""
    height, width = frame.shape[:2]
    text, (wide, high), scale, thickness = _fitted(text, max(9.0, 0.035 * height), 0.6 * width)
    pad = max(2, high // 2)
    top, left = max(0, height - high - 3 * pad), max(0, width - wide - 3 * pad)
    result = frame.copy()
    # A darkened box keeps the letters legible on any background.
    result[top : height - pad, left : width - pad] //= 2
    return _with_text(result, text, (left + pad, height - 2 * pad), scale, thickness, 255)


def _fitted(text: str, height: float, width: float):
    """Text in ASCII, its (width, height) in pixels, scale and thickness, at most ``height`` high and ``width`` wide."""
    import cv2

    text = text.encode("ascii", "replace").decode()
    (wide, high), _ = cv2.getTextSize(text or " ", _FONT, 1.0, 1)
    scale = min(height / max(high, 1), width / max(wide, 1))
    thickness = max(1, round(scale))
    size, _ = cv2.getTextSize(text or " ", _FONT, scale, thickness)
    return text, size, scale, thickness


def _with_text(image: np.ndarray, text: str, position: tuple[int, int], scale: float, thickness: int, grey: int):
    import cv2

    return cv2.putText(image, text, position, _FONT, scale, (grey,) * 3, thickness, cv2.LINE_AA)
