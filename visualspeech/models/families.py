"""The families of models by name. For planning: imports no model.

A family is named by the module that implements it, with ``fit(task) -> Fitted`` and
``restore(arrays, settings, path) -> Model`` (:mod:`visualspeech.models.task`). The module is imported when a model is
trained, and its code is part of the digest of its own rows alone: a new family re-trains nobody.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from visualspeech.models.joint_settings import cell_name


@dataclass(frozen=True)
class Family:
    """One family of models.

    Parameters
    ----------
    module : that implements it
    settings : ``module:Class`` of its settings, importable without torch; empty for none
    trained : whether it is trained by the loop of :mod:`visualspeech.models.training`
    role : of its rows, see :data:`visualspeech.models.rows.ROLES`
    grid : settings that may be lists in ``models:``; every combination is a row
    cell : name of such a row, from the settings
    title : of a row in tables, from its name and settings
    reads : least and largest number of input blocks; None: any number
    segmental : whether it reads input blocks of segments, with start times; otherwise of frames
    made_of : key of an entry that names the finished rows that a row is made of, of any family: ``from`` for one, or
        ``members`` for several; the row reads what they read. Empty: none
    no_windows : why a row of these settings cannot read windows of frames, as the rest of a sentence; empty: it can
    by_frame : whether a model predicts each frame from its own inputs alone, so that it can be trained on single frames
    regions : whether it needs a visual coding that divides its parameters into regions of the face
    made_from : whether a row of these settings starts from the model of another row, which ``from`` names
    """

    module: str
    settings: str = ""
    trained: bool = False
    role: str = "model"
    grid: tuple[str, ...] = ()
    cell: Callable[[Mapping], str] = lambda settings: ""
    title: Callable[[str, Mapping], str] = lambda name, settings: name
    reads: tuple[int, int | None] = (0, None)
    segmental: bool = False
    made_of: str = ""
    made_from: Callable[[Mapping], bool] = lambda settings: False
    no_windows: Callable[[Mapping], str] = lambda settings: "this family reads none. Name the block alone."
    by_frame: bool = False
    regions: bool = False


_OF_STACKS = "a stack reads windows by a feed-forward layer. Begin `letters` with F, or name the block alone."
_HMM_TITLES = {
    "geometric": {"monophone": "monophone HMM", "tied": "tied-state triphone HMM", "mge": "MGE-trained HMM"},
    "gaussian": {"monophone": "monophone HSMM", "tied": "tied-state quinphone HSMM", "mge": "MGE-trained HSMM"},
}

FAMILIES = {
    "stack": Family(
        "visualspeech.models.stack",
        "visualspeech.models.stack_settings:StackSettings",
        trained=True,
        grid=("letters", "nodes"),
        cell=lambda settings: f"{settings['letters']}-{settings['nodes']}",
        reads=(1, None),
        no_windows=lambda settings: "" if settings["letters"].startswith("F") else _OF_STACKS,
    ),
    "hmm": Family(
        "visualspeech.models.hmm.family",
        "visualspeech.models.hmm.model:HmmSettings",
        title=lambda name, settings: _HMM_TITLES[settings["durations"]][settings["variant"]],
        reads=(1, 1),
        segmental=True,
        made_from=lambda settings: settings["variant"] != "monophone",
    ),
    "ensemble": Family(
        "visualspeech.models.ensemble",
        "visualspeech.models.combined_settings:EnsembleSettings",
        reads=(0, 0),
        made_of="members",
    ),
    "gv_compensation": Family(
        "visualspeech.models.gv_compensation",
        "visualspeech.models.combined_settings:GvCompensationSettings",
        reads=(0, 0),
        made_of="from",
        made_from=lambda settings: True,
    ),
    "dnn": Family(
        "visualspeech.models.dnn",
        "visualspeech.models.dnn_settings:DnnSettings",
        trained=True,
        grid=("layers", "nodes"),
        cell=lambda settings: f"DNN-{settings['layers']}x{settings['nodes']}",
        reads=(1, None),
        no_windows=lambda settings: "",
        by_frame=True,
    ),
    "joint": Family(
        "visualspeech.models.joint",
        "visualspeech.models.joint_settings:JointSettings",
        trained=True,
        grid=("layers", "nodes", "shared"),
        cell=cell_name,
        reads=(1, None),
        no_windows=lambda settings: "",
        regions=True,
    ),
    "lookup": Family(
        "visualspeech.models.lookup",
        "visualspeech.models.lookup_settings:LookupSettings",
        role="baseline",
        title=lambda name, settings: f"{settings['context']}-state mean",
        reads=(1, 1),
    ),
    "mean": Family(
        "visualspeech.models.mean", role="baseline", title=lambda name, settings: "training mean", reads=(0, 0)
    ),
    # Not trained: the true parameters as if they were a prediction. Its error is that of the visual coding alone.
    "reconstruction": Family("", role="floor", title=lambda name, settings: "reconstruction (floor)", reads=(0, 0)),
}
