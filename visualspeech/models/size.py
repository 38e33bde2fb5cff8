"""The size of a model: how many numbers its training has estimated."""

from collections.abc import Mapping

import numpy as np

_MEMBERS, _BLOCKS, _WEIGHTS = "members.", "blocks.", "weights."


def parameter_count(arrays: Mapping[str, np.ndarray]) -> int:
    """Number of parameters of a model whose file holds these arrays.

    Of a network the weights and biases; of any other model all real numbers (means, variances, durations, transition
    probabilities); of a model that is made of others, those of all its members and its own. The input blocks in the
    file and the scaling of a network's outputs are no parameters of the model.
    """
    members: dict[str, dict[str, np.ndarray]] = {}
    own: dict[str, np.ndarray] = {}
    for name, values in arrays.items():
        if name.startswith(_MEMBERS):
            number, _, rest = name.removeprefix(_MEMBERS).partition(".")
            members.setdefault(number, {})[rest] = values
        elif not name.startswith(_BLOCKS):
            own[name] = values
    weights = {name: values for name, values in own.items() if name.startswith(_WEIGHTS)}
    count = sum(int(values.size) for values in (weights or own).values() if values.dtype.kind == "f")
    return count + sum(map(parameter_count, members.values()))
