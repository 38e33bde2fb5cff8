"""Layers over the real frames of a batch of utterances, without any padding: convolutions, recurrent layers, dropout.

A batch is (frames, features) in torch's packed order: the first frame of every utterance, the longest utterance first,
then the second frame of every utterance that has one, and so on. ``counts`` (T,) says how many utterances have a frame
t (``PackedSequence.batch_sizes``).
"""

import torch
from torch import nn
from torch.nn.utils.rnn import PackedSequence

#: Frames from the centre of a convolution to its outer taps, over consecutive convolutions; then from the start again.
DILATIONS = (1, 2, 4, 8)


class GatedConvolution(nn.Module):
    """A gated dilated convolution of three frames with a residual connection (van den Oord et al. 2016, Eq. 2, Fig. 4).

    y = x + R z + r,  z = tanh(f) * sigmoid(g),  (f, g) of frame t = W (x of the frames t - d, t, t + d) + w,

    for a dilation of d frames. WaveNet's convolutions look at the past alone; here the future is known. Frames before
    an utterance's start and after its end are zero. x is the input; if it has another width than the layer, it is
    brought to it by a linear map first. There are no skip connections past the layers above.

    Parameters
    ----------
    inputs, nodes : width of the input and of the layer
    dilation : d in frames
    dropout : share of the gated values z set to zero in training. What is dropped of the sum y would be lost to all
        layers above
    """

    def __init__(self, inputs: int, nodes: int, dilation: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.dilation = dilation
        self.dropout = dropout
        self.projection = nn.Linear(inputs, nodes) if inputs != nodes else None
        self.gates = nn.Linear(3 * nodes, 2 * nodes)
        self.residual = nn.Linear(nodes, nodes)

    def forward(self, frames: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
        """Outputs (frames, nodes) of (frames, inputs) in packed order."""
        x = frames if self.projection is None else self.projection(frames)
        before, after = neighbours(counts, self.dilation)
        # The last row stands for all frames that no utterance has.
        padded = torch.cat([x, x.new_zeros(1, x.shape[1])])
        filters, gates = self.gates(torch.cat([padded[before], x, padded[after]], dim=1)).chunk(2, dim=1)
        gated = torch.tanh(filters) * torch.sigmoid(gates)
        return x + self.residual(dropped(gated, self.dropout) if self.training else gated)

    @staticmethod
    def shapes(inputs: int, nodes: int) -> dict[str, tuple[int, ...]]:
        """Shape of each weight by name, without making a layer."""
        projection = {"projection.weight": (nodes, inputs), "projection.bias": (nodes,)} if inputs != nodes else {}
        gates = {"gates.weight": (2 * nodes, 3 * nodes), "gates.bias": (2 * nodes,)}
        return {**projection, **gates, "residual.weight": (nodes, nodes), "residual.bias": (nodes,)}


class BidirectionalLstm(nn.LSTM):
    """A bidirectional LSTM layer (Fan 2015, Eq. 1 to 8), with the weights and the names of torch's.

    Torch computes a packed batch of unequal lengths frame by frame, which takes about three times as long. Here such a
    batch is padded, and each direction reads it from its own first frame on, so that no frame of an utterance sees the
    padding behind it.

    Parameters
    ----------
    inputs, nodes : width of the input, and of the state of each direction
    bias : whether the gates have biases
    """

    def __init__(self, inputs: int, nodes: int, bias: bool = True) -> None:
        super().__init__(inputs, nodes, bias=bias, batch_first=True, bidirectional=True)

    def forward(self, frames: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
        """Outputs (frames, 2 nodes) of (frames, inputs) in packed order, those of the forward direction first."""
        if counts[0] == counts[-1]:
            return super().forward(PackedSequence(frames, counts))[0].data
        forwards, backwards, places, mirrored = padded_places(counts)
        padded = torch.cat([frames, frames.new_zeros(1, frames.shape[1])])
        ahead = self._direction(padded, forwards, "").index_select(0, places)
        return torch.cat([ahead, self._direction(padded, backwards, "_reverse").index_select(0, mirrored)], dim=1)

    def _direction(self, padded: torch.Tensor, order: torch.Tensor, ending: str) -> torch.Tensor:
        """States (B T, nodes) of one direction that reads rows of ``padded`` in the order (B, T)."""
        given = padded.index_select(0, order.flatten()).view(*order.shape, padded.shape[1])
        names = ("weight_ih", "weight_hh", "bias_ih", "bias_hh") if self.bias else ("weight_ih", "weight_hh")
        weights = [getattr(self, f"{name}_l0{ending}") for name in names]
        start = padded.new_zeros(1, len(order), self.hidden_size)
        states = torch.lstm(given, (start, start), weights, self.bias, 1, 0.0, self.training, False, True)[0]
        return states.flatten(0, 1)


def padded_places(counts: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
    """How B utterances of T frames at most lie in packed order, and how in padded batches of both directions.

    Parameters
    ----------
    counts : (T,) int64, utterances that have a frame t, descending

    Returns
    -------
    ``forwards`` (B, T) and ``backwards`` (B, T): place in packed order of the frame that is read at a step, from the
    first frame on and from the last one back; the number of frames behind an utterance's end. ``places`` (frames,) and
    ``mirrored`` (frames,): place of each frame in the flattened batch of either direction
    """
    total, times, utterances = int(counts.sum()), len(counts), int(counts[0])
    starts = counts.cumsum(0) - counts
    time = torch.repeat_interleave(torch.arange(times), counts)
    utterance = torch.arange(total) - starts[time]
    lengths = (counts[None, :] > torch.arange(utterances)[:, None]).sum(dim=1)
    places, mirrored = utterance * times + time, utterance * times + lengths[utterance] - 1 - time
    forwards, backwards = torch.full((2, utterances * times), total).unbind()
    forwards = forwards.index_copy(0, places, torch.arange(total))
    backwards = backwards.index_copy(0, mirrored, torch.arange(total))
    return forwards.view(utterances, times), backwards.view(utterances, times), places, mirrored


def dilations(letters: str) -> list[int]:
    """Dilation of each layer of a stack that is a convolution (C), 0 for others; every run of C begins anew."""
    found, run = [], 0
    for letter in letters:
        found.append(DILATIONS[run % len(DILATIONS)] if letter == "C" else 0)
        run = run + 1 if letter == "C" else 0
    return found


def neighbours(counts: torch.Tensor, distance: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Place in packed order of the frame ``distance`` before and after each frame of the same utterance.

    Parameters
    ----------
    counts : (T,) int64, utterances that have a frame t, descending

    Returns
    -------
    (frames,) int64 each; the number of frames where the utterance has no such frame
    """
    total, times = int(counts.sum()), len(counts)
    starts = counts.cumsum(0) - counts
    time = torch.repeat_interleave(torch.arange(times), counts)
    utterance = torch.arange(total) - starts[time]
    earlier, later = (time - distance).clamp(min=0), (time + distance).clamp(max=times - 1)
    before = torch.where(time >= distance, starts[earlier] + utterance, total)
    after = torch.where((time + distance < times) & (utterance < counts[later]), starts[later] + utterance, total)
    return before, after


def dropped(values: torch.Tensor, share: float) -> torch.Tensor:
    """Values with a random share of them zero and the others larger by 1 / (1 - share), as in training with dropout.

    The same as :func:`torch.nn.functional.dropout` with other random numbers: uniform ones, which a processor draws
    three times as fast as torch's Bernoulli ones; those were a tenth of an update.
    """
    if not share:
        return values
    return values * torch.rand_like(values).ge_(share).mul_(1 / (1 - share))
