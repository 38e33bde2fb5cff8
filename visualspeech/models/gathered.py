"""A linear layer on one-hot inputs that adds up rows of its weights, where a product would multiply by zeros."""

import math
from collections.abc import Sequence
from itertools import accumulate

import torch
from torch import nn
from torch.nn.functional import embedding_bag, linear

from visualspeech.features.streams import Layout
from visualspeech.models.frames import Frames


class GatheredLinear(nn.Module):
    """W x + b, where x is the window of each input around a frame: one-hot vectors, then real values.

    Of an input with classes, x has the one-hot vectors of all its categorical columns of the first frame of its
    window, then those of the second frame, and so on; the classes of all inputs come first, then the real values of all
    inputs in the same order. Frames outside the utterance are zero. For a window of 33 frames of 41 phones, 33 rows are
    added where the product has 1,353 columns. The rows are those of ``classes``, the transposed part of W.

    Weights are uniform between +-1 / sqrt(k) with k the inputs that are not zero at a frame inside: torch's rule for a
    linear layer with a width of k.

    Parameters
    ----------
    layouts : columns and windows of the inputs
    nodes : width of the layer
    """

    def __init__(self, layouts: Sequence[Layout], nodes: int) -> None:
        super().__init__()
        self.layouts = tuple(layouts)
        shapes, bound = self.shapes(layouts, nodes), 1 / math.sqrt(max(sum(map(_active, layouts)), 1))
        for name, shape in shapes.items():
            self.register_parameter(name, nn.Parameter(torch.empty(shape).uniform_(-bound, bound)))
        starts = [0, *accumulate(layout.frames * sum(layout.sizes) for layout in layouts)]
        self.rows = [_first_rows(layout, start) for layout, start in zip(layouts, starts[:-1], strict=True)]

    def forward(self, frames: Frames) -> torch.Tensor:
        """Outputs (M, nodes) at the M frames that are asked for."""
        rows, inside, values = self._inputs(frames)
        outputs = self.bias.expand(len(frames.at), -1)
        if rows is not None:
            # Rows outside the utterance are left out of the bag of their frame.
            counts = inside.sum(dim=1)
            bags = embedding_bag(rows[inside], self.classes, counts.cumsum(0) - counts, mode="sum")
            outputs = outputs + bags
        return outputs if values is None else outputs + linear(values, self.values)

    def _inputs(self, frames: Frames):
        """Rows of ``classes`` and whether they count, (M, K) each, and values (M, R); None where there are none."""
        rows, inside, values, column, value = [], [], [], 0, 0
        for layout, first in zip(self.layouts, self.rows, strict=True):
            numbers, within = frames.around(layout.window)
            if layout.sizes:
                chosen = frames.index[:, column : column + len(layout.sizes)][numbers]
                rows.append((chosen + first).flatten(1))
                inside.append(within[:, :, None].expand_as(chosen).flatten(1))
            if layout.dimension:
                chosen = frames.values[:, value : value + layout.dimension][numbers]
                values.append((chosen * within[:, :, None]).flatten(1))
            column, value = column + len(layout.sizes), value + layout.dimension
        together = (torch.cat(parts, dim=1) if parts else None for parts in (rows, inside, values))
        return tuple(together)

    @staticmethod
    def shapes(layouts: Sequence[Layout], nodes: int) -> dict[str, tuple[int, ...]]:
        """Shape of each weight by name, without making a layer."""
        classes = sum(layout.frames * sum(layout.sizes) for layout in layouts)
        values = sum(layout.frames * layout.dimension for layout in layouts)
        found = {"classes": (classes, nodes)} if classes else {}
        return found | ({"values": (nodes, values)} if values else {}) | {"bias": (nodes,)}


def _active(layout: Layout) -> int:
    """Inputs that are not zero at a frame whose window is inside its utterance."""
    return layout.frames * (len(layout.sizes) + layout.dimension)


def _first_rows(layout: Layout, start: int) -> torch.Tensor:
    """Row of class 0 of each frame of a window and each categorical column, (frames, columns) int64."""
    columns = torch.tensor([0, *accumulate(layout.sizes)][: len(layout.sizes)], dtype=torch.int64)
    return start + sum(layout.sizes) * torch.arange(layout.frames)[:, None] + columns
