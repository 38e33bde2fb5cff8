"""Which Gaussian a state of a triphone has: decision trees, grown by likelihood and stopped by description length."""

from dataclasses import dataclass

import numpy as np

from visualspeech.models.hmm.questions import Questions


@dataclass(frozen=True)
class Tying:
    """Decision trees from (left, current, right phone, state) to the number of a Gaussian.

    A node is a number of at least 0; a leaf with Gaussian g is -1 - g.

    Parameters
    ----------
    roots : (S, K) node or leaf at which state s of phone k begins
    positions : (nodes,) the part of the triphone that a node asks about
    members : (nodes, K) bool, the phones for which the answer is yes
    branches : (nodes, 2) node or leaf after no and after yes
    """

    roots: np.ndarray
    positions: np.ndarray
    members: np.ndarray
    branches: np.ndarray

    @property
    def gaussians(self) -> int:
        """Number of Gaussians."""
        return int(-min(self.roots.min(), self.branches.min(initial=0)))

    def find(self, triphones: np.ndarray) -> np.ndarray:
        """Gaussians (P, S) of the states of triphones (P, 3)."""
        place = self.roots[:, triphones[:, 1]].T.copy()
        while (inside := place >= 0).any():
            row, _ = np.nonzero(inside)
            node = place[inside]
            answer = self.members[node, triphones[row, self.positions[node]]]
            place[inside] = self.branches[node, answer.astype(int)]
        return -1 - place


def monophones(phones: int, states: int) -> Tying:
    """A Gaussian for each state of each phone, whatever its neighbours."""
    roots = -1 - np.arange(phones * states).reshape(phones, states).T
    return Tying(roots, np.zeros(0, int), np.zeros((0, phones), bool), np.zeros((0, 2), int))


@dataclass(frozen=True)
class Cases:
    """Triphone states with the statistics of their frames.

    Parameters
    ----------
    triphones : (M, 3) phone indices
    states : (M,)
    occupancy : (M,) expected frames
    first, second : (M, D) sums over frames of the observation and of its square
    """

    triphones: np.ndarray
    states: np.ndarray
    occupancy: np.ndarray
    first: np.ndarray
    second: np.ndarray

    def part(self, chosen: np.ndarray) -> "Cases":
        """The chosen of them."""
        return Cases(*(getattr(self, name)[chosen] for name in Cases.__dataclass_fields__))


def log_likelihood(occupancy, first, second, floor: np.ndarray) -> np.ndarray:
    """Log-likelihood of frames under the one diagonal Gaussian that fits them best; of each row of statistics.

    Parameters
    ----------
    occupancy : (...,) frames
    first, second : (..., D) sums of values and of squares
    floor : (D,) least variance
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
    floor: np.ndarray,
    min_frames: float,
    mdl: float = 1.0,
    of_each_phone: bool = False,
) -> Tying:
    """Trees that tie the states of triphones (Odell 1995), each split the one of greatest likelihood.

    A split is made while it shortens the description (Shinoda and Watanabe 2000, Eq. 12): while its gain in
    log-likelihood exceeds ``mdl`` * D * log(frames of the tree), the cost of one more Gaussian of 2 D parameters.

    Parameters
    ----------
    cases : statistics of the triphone states that training has; what it lacks follows its answers down the tree
    floor : (D,) least variance
    min_frames : frames that a Gaussian must rest on
    mdl : weight of the description length; 1: as published, less: more Gaussians
    of_each_phone : a tree for each state of each phone, else for each state of all phones
    """
    nodes: list[tuple[int, np.ndarray, list[int]]] = []
    leaves = 0
    roots = np.zeros((states, phones), int)

    def plant(part: Cases, cost: float) -> int:
        nonlocal leaves
        best = _best_split(part, questions, floor, min_frames)
        if best is None or best[0] <= cost:
            leaves += 1
            return -leaves
        _, question, yes = best
        node, branch = len(nodes), [0, 0]
        nodes.append((int(questions.positions[question]), questions.members[question], branch))
        branch[0], branch[1] = plant(part.part(~yes), cost), plant(part.part(yes), cost)
        return node

    for state in range(states):
        for phone in range(phones) if of_each_phone else (slice(None),):
            here = cases.states == state
            if of_each_phone:
                here = here & (cases.triphones[:, 1] == phone)
            part = cases.part(here)
            roots[state, phone] = plant(part, mdl * len(floor) * np.log(max(part.occupancy.sum(), np.e)))
    return Tying(
        roots,
        np.array([node[0] for node in nodes], int),
        np.array([node[1] for node in nodes], bool).reshape(len(nodes), phones),
        np.array([node[2] for node in nodes], int).reshape(len(nodes), 2),
    )


def _best_split(part: Cases, questions: Questions, floor: np.ndarray, min_frames: float):
    """(gain in log-likelihood, question, cases with yes) of the best split; None where none leaves enough frames."""
    answers = questions.answers(part.triphones)
    total = part.occupancy.sum()
    held = answers @ part.occupancy
    able = np.flatnonzero((held >= min_frames) & (total - held >= min_frames))
    if not len(able):
        return None
    # Questions that split these cases in the same way need to be asked once; the first of them is kept.
    _, first = np.unique(np.packbits(answers[able], axis=1), axis=0, return_index=True)
    able = able[np.sort(first)]
    chosen = answers[able].astype(float)
    sums = (part.occupancy, part.first, part.second)
    masks = (chosen, 1 - chosen, np.ones(len(part.occupancy)))
    yes, no, together = (log_likelihood(*(mask @ values for values in sums), floor) for mask in masks)
    gain = yes + no - together
    best = int(np.argmax(gain))
    return float(gain[best]), int(able[best]), answers[able[best]]
