"""State tying: decision trees that maximise the likelihood, with minimum description length as stopping criterion."""

from dataclasses import dataclass

import numpy as np

from visualspeech.models.hmm.questions import Questions
from visualspeech.models.hmm.segments import ContextLayout, Factor

#: Frames by which sums of expected frames may differ by rounding. States at given times have whole numbers of frames;
#: without this it depended on the processor whether a part with just as many as a Gaussian needs had enough.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Tying:
    """Decision trees from a phone in context and a state to the number of a Gaussian.

    Nodes are numbered from 0; a leaf with Gaussian g is written -1 - g.

    Parameters
    ----------
    roots : (S, K) node or leaf at which state s of phone k starts
    positions : (nodes,) column of the context that a node asks about
    members : (nodes, V) bool, phones or numbers for which the answer is yes
    branches : (nodes, 2) node or leaf after no and after yes
    columns : number of columns C of a context that hold phones
    centre : column of the phone itself
    divisions : number D of divisions of a phone, each with S / D of its states; a further last column of the contexts
        holds the number of the division. 1: phones are not divided
    factors : columns of numbers that follow those of the phones
    """

    roots: np.ndarray
    positions: np.ndarray
    members: np.ndarray
    branches: np.ndarray
    columns: int
    centre: int
    divisions: int = 1
    factors: tuple[Factor, ...] = ()

    @property
    def layout(self) -> ContextLayout:
        """As :attr:`visualspeech.models.hmm.segments.PhoneTrack.layout`."""
        return ContextLayout(self.columns, self.centre, self.divisions, self.factors)

    @property
    def unit_states(self) -> int:
        """Number of states of a division of a phone."""
        return len(self.roots) // self.divisions

    @property
    def gaussians(self) -> int:
        """Number of Gaussians."""
        return int(-min(self.roots.min(), self.branches.min(initial=0)))

    def find(self, contexts: np.ndarray) -> np.ndarray:
        """Gaussians (P, S / D) of the states of phones in context, or of their divisions."""
        states = units(contexts, self.centre, self.divisions)[:, None] * self.unit_states + np.arange(self.unit_states)
        phone, state = np.divmod(states, len(self.roots))
        reached = self.roots[state, phone]
        while (inner := reached >= 0).any():
            row, _ = np.nonzero(inner)
            node = reached[inner]
            answer = self.members[node, contexts[row, self.positions[node]]]
            reached[inner] = self.branches[node, answer.astype(int)]
        return -1 - reached


def units(contexts: np.ndarray, centre: int, divisions: int) -> np.ndarray:
    """Number (P,) of each row's unit: phone, or phone * divisions + division, which the last column then holds."""
    return contexts[:, centre] if divisions == 1 else contexts[:, centre] * divisions + contexts[:, -1]


def monophones(phones: int, states: int, layout: ContextLayout = ContextLayout(3, 1)) -> Tying:  # noqa: B008
    """One Gaussian for each state of each phone, the same in every context; the default layout is that of triphones."""
    roots = -1 - np.arange(phones * states).reshape(phones, states).T
    width = max(layout.sizes(phones)[: layout.columns + len(layout.factors)])
    nodes = np.zeros(0, int), np.zeros((0, width), bool), np.zeros((0, 2), int)
    return Tying(roots, *nodes, *layout)


@dataclass(frozen=True)
class Cases:
    """States of phones in context, with the statistics of their frames.

    Parameters
    ----------
    contexts : (M, C) phone indices and numbers
    states : (M,) number of the state in its phone
    occupancy : (M,) expected frames
    first, second : (M, D) sums over frames of the observation and of its square
    """

    contexts: np.ndarray
    states: np.ndarray
    occupancy: np.ndarray
    first: np.ndarray
    second: np.ndarray

    def subset(self, chosen: np.ndarray) -> "Cases":
        """The cases that a mask (M,) bool selects."""
        return Cases(*(getattr(self, name)[chosen] for name in Cases.__dataclass_fields__))


def log_likelihood(occupancy, first, second, floor: np.ndarray) -> np.ndarray:
    """Log-likelihood of frames under their maximum-likelihood diagonal Gaussian, for each row of statistics.

    Parameters
    ----------
    occupancy : (...,) frames
    first, second : (..., D) sums of values and of squares
    floor : (D,) minimum variance
    """
    safe = np.maximum(occupancy, 1e-10)[..., None]
    spread = np.maximum(second / safe - (first / safe) ** 2, 0)
    variance = np.maximum(spread, floor)
    each = np.log(2 * np.pi * variance) + spread / variance
    return -0.5 * occupancy * each.sum(axis=-1)


def grow(
    cases: Cases,
    questions: Questions,
    phones: int,
    states: int,
    centre: int,
    floor: np.ndarray,
    min_frames: float,
    mdl: float = 1.0,
    of_each_phone: bool = False,
    divisions: int = 1,
    factors: tuple[Factor, ...] = (),
) -> Tying:
    """Decision trees that tie the states of phones in context (Odell 1995); each split maximises the likelihood.

    A node is split while that reduces the description length (Shinoda and Watanabe 2000, Eq. 12): while the gain in
    log-likelihood exceeds ``mdl`` * D * log(frames of the tree), the cost of one more Gaussian with 2 D parameters.

    Parameters
    ----------
    cases : statistics of the states that occur in training; contexts that do not occur reach a leaf by their answers
    questions : what a node may ask, for contexts of the same layout
    phones, states : numbers K and S
    centre : column of the phone itself in the contexts
    floor : (D,) minimum variance
    min_frames : minimum frames per Gaussian
    mdl : weight of the description length; 1: as published, less: more Gaussians
    of_each_phone : one tree for each state of each phone, else one for each state of all phones together
    divisions : of the phones, whose number the last column of the contexts then holds
    factors : columns of the contexts that follow those of the phones
    """
    nodes: list[tuple[int, np.ndarray, list[int]]] = []
    leaves = 0
    roots = np.zeros((states, phones), int)

    def split(part: Cases, asked: Questions, cost: float) -> int:
        nonlocal leaves
        asked, answers = _able(part, asked, min_frames)
        gain = _gains(part, answers, floor) if len(answers) else np.array([-np.inf])
        best = int(np.argmax(gain))
        if gain[best] <= cost:
            leaves += 1
            return -leaves
        yes, node, branch = answers[best].copy(), len(nodes), [0, 0]
        nodes.append((int(asked.positions[best]), asked.members[best], branch))
        del answers
        branch[0], branch[1] = split(part.subset(~yes), asked, cost), split(part.subset(yes), asked, cost)
        return node

    for state in range(states):
        for phone in range(phones) if of_each_phone else (slice(None),):
            here = cases.states == state
            if of_each_phone:
                here = here & (cases.contexts[:, centre] == phone)
            part = cases.subset(here)
            roots[state, phone] = split(part, questions, mdl * len(floor) * np.log(max(part.occupancy.sum(), np.e)))
    return Tying(
        roots,
        np.array([node[0] for node in nodes], int),
        np.array([node[1] for node in nodes], bool).reshape(len(nodes), questions.members.shape[1]),
        np.array([node[2] for node in nodes], int).reshape(len(nodes), 2),
        cases.contexts.shape[1] - len(factors) - (divisions > 1),
        centre,
        divisions,
        factors,
    )


def _able(part: Cases, questions: Questions, min_frames: float) -> tuple[Questions, np.ndarray]:
    """The questions that split the cases of a node into parts of enough frames, and their answers (Q, M).

    What is left out here splits no part of these cases better: its parts are smaller still, or it splits them as the
    first of the questions that split all of them alike, or the other way round.
    """
    answers = questions.answers(part.contexts)
    held, least = answers @ part.occupancy, min_frames - ROUNDING
    able = np.flatnonzero((held >= least) & (part.occupancy.sum() - held >= least))
    alike = answers[able] ^ answers[able, :1]
    _, first = np.unique(np.packbits(alike, axis=1), axis=0, return_index=True)
    able = able[np.sort(first)]
    return questions.subset(able), answers[able]


def _gains(part: Cases, answers: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Gain in log-likelihood (Q,) of the splits of the cases of a node by answers (Q, M)."""
    whole, chosen = (part.occupancy, part.first, part.second), answers.astype(float)
    yes = [chosen @ values for values in whole]
    whole = [values.sum(axis=0) for values in whole]
    no = [values - held for values, held in zip(whole, yes, strict=True)]
    return sum(log_likelihood(*sums, floor) for sums in (yes, no)) - log_likelihood(*whole, floor)
