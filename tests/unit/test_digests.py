"""What re-trains what: digests of a row's code after changes to a copy of the library."""

import shutil

import pytest

from tests.paths import REPOSITORY
from visualspeech import provenance
from visualspeech.features.blocks.base import block_kinds, block_module
from visualspeech.models.families import FAMILIES
from visualspeech.models.registry import code_modules
from visualspeech.models.rows import ModelRow

TRAIN = REPOSITORY / "workflow" / "scripts" / "train_model.py"
#: Family of a row and the kinds of the blocks that it reads.
ROWS = {
    "stack": ("stack", ["triphone_state"]),
    "rich": ("stack", ["triphone_state", "label_parts"]),
    "classes": ("stack", ["phone_classes"]),
    "heard": ("stack", ["log_mel", "arrays"]),
    "spoken": ("stack", ["speech27", "speech44"]),
    "context": ("stack", ["phone", "linguistic"]),
    "visemes": ("stack", ["dynamic_visemes", "viseme_context"]),
    "dnn": ("dnn", ["triphone_state"]),
    "joint": ("joint", ["triphone_state"]),
    "hmm": ("hmm", ["phone_track"]),
    "hsmm": ("hmm", ["full_context"]),
    "lookup": ("lookup", ["triphone_state"]),
    "mean": ("mean", []),
    "ensemble": ("ensemble", ["triphone_state", "phone_track"]),
    "gv": ("gv_compensation", ["triphone_state"]),
}
#: Rows that a row is made of; their code is part of its own.
PARENTS = {"ensemble": ("stack", "hmm"), "gv": ("stack",)}
#: Rows of networks, and those that are made of some.
NETWORKS = {
    "stack", "rich", "classes", "heard", "spoken", "context", "visemes", "dnn", "joint", "ensemble", "gv",
}  # fmt: skip


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A copy of the library that may be edited, and the digests of all rows from it."""
    copy = shutil.copytree(provenance.PACKAGE, tmp_path / "visualspeech", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "PACKAGE", copy)
    yield copy
    forget()


def forget():
    for function in (provenance._read, provenance._files):
        function.cache_clear()


def digests(script=TRAIN):
    """As another process would make them, with the modules that the rules name (``workflow/rules``)."""
    forget()
    rows = [ModelRow(name, name, family, parents=PARENTS.get(name, ())) for name, (family, _) in ROWS.items()]
    return {
        row.name: provenance.code_digest(script, *code_modules(row, rows), *map(block_module, ROWS[row.name][1]))
        for row in rows
    }


def edited(package, *parts, text="\n\nADDED = 1\n"):
    path = package.joinpath(*parts)
    path.write_text(path.read_text() + text)
    assert text.strip() in path.read_text()


def changed(before, after):
    return {row for row in before if before[row] != after[row]}


def test_the_rows_are_all_families_and_kinds():
    assert {family for family, _ in ROWS.values()} == {name for name, one in FAMILIES.items() if one.module}
    assert {kind for _, kinds in ROWS.values() for kind in kinds} == set(block_kinds())


def test_the_copy_has_the_digests_of_the_original(package, monkeypatch):
    of_copy = digests()
    monkeypatch.setattr(provenance, "PACKAGE", REPOSITORY / "visualspeech")
    assert digests() == of_copy


@pytest.mark.parametrize(
    ("module", "rows"),
    [
        ("models/hmm/family.py", {"hmm", "hsmm", "ensemble"}),
        ("models/hmm/mge.py", {"hmm", "hsmm", "ensemble"}),
        ("models/hmm/model.py", {"hmm", "hsmm", "ensemble"}),
        ("models/hmm/tying.py", {"hmm", "hsmm", "ensemble"}),
        ("models/trajectory/generation.py", NETWORKS | {"hmm", "hsmm"}),
        ("models/trajectory/mlpg.py", NETWORKS),
        ("models/layers.py", NETWORKS),
        ("models/fitting.py", NETWORKS),
        ("models/ensemble.py", {"ensemble"}),
        ("models/gv_compensation.py", {"gv"}),
        ("models/members.py", {"ensemble", "gv"}),
        ("models/combined_settings.py", {"ensemble", "gv"}),
        ("models/combined_rows.py", set()),
        ("models/stack.py", NETWORKS - {"dnn", "joint"}),
        ("models/stack_settings.py", NETWORKS - {"dnn", "joint"}),
        ("models/dnn.py", {"dnn"}),
        ("models/dnn_settings.py", {"dnn"}),
        ("models/joint.py", {"joint"}),
        ("models/joint_network.py", {"joint"}),
        ("models/joint_settings.py", {"joint"}),
        ("models/gathered.py", NETWORKS),
        ("models/frames.py", NETWORKS),
        ("models/reads.py", set()),
        ("models/training.py", NETWORKS),
        ("models/objectives.py", NETWORKS),
        ("models/lookup.py", {"lookup"}),
        ("models/lookup_settings.py", {"lookup"}),
        ("models/mean.py", {"mean"}),
        ("models/families.py", set()),
        ("models/entries.py", set()),
        ("models/registry.py", set()),
        ("models/rest.py", set()),
        ("models/inventory.py", set()),
        (
            "features/blocks/triphone_state.py",
            (NETWORKS | {"lookup"}) - {"classes", "heard", "spoken", "context", "visemes"},
        ),
        ("features/blocks/label_parts.py", {"rich"}),
        ("features/blocks/phone_track.py", {"hmm", "ensemble"}),
        ("features/blocks/phone_classes.py", {"classes"}),
        ("speech/phone_classes.py", {"hmm", "hsmm", "classes", "context", "visemes", "ensemble"}),
        ("features/blocks/log_mel.py", {"heard"}),
        ("features/blocks/arrays.py", {"heard"}),
        ("speech/acoustics.py", {"heard"}),
        ("features/blocks/speech27.py", {"spoken"}),
        ("features/speech_block.py", {"spoken"}),
        ("speech/speech_features.py", {"spoken"}),
        ("speech/praat.py", {"spoken"}),
        ("speech/egemaps.py", {"spoken"}),
        ("features/blocks/linguistic.py", {"context"}),
        ("features/linguistic.py", {"context", "visemes"}),
        ("features/unit_contexts.py", {"context", "visemes"}),
        ("features/blocks/dynamic_visemes.py", {"visemes"}),
        ("features/blocks/viseme_context.py", {"visemes"}),
        ("features/visemes/prediction.py", {"visemes"}),
        ("speech/segmentation.py", set()),
        ("planning/run.py", set()),
        ("planning/systems.py", set()),
        ("schema.py", set()),
        ("features/streams.py", set(ROWS)),
    ],
)
def test_an_edit_reaches_the_rows_that_use_it(package, module, rows):
    before = digests()
    edited(package, module)
    assert changed(before, digests()) == rows


@pytest.mark.parametrize("folder", ["api", "evaluation", "animation", "face", "planning", "corpora/demo"])
def test_other_parts_of_the_library_re_train_nobody(package, folder):
    before = digests()
    for path in (package / folder).rglob("*.py"):
        edited(package, path.relative_to(package))
    assert changed(before, digests()) == set()


def test_a_new_family_re_trains_nobody(package):
    before = digests()
    (package / "models" / "forest.py").write_text('FAMILY = "forest"\n\n\ndef fit(task):\n    return 3\n')
    listed = package / "models" / "families.py"
    entry = '    "forest": Family("visualspeech.models.forest"),\n    "mean": Family('
    listed.write_text(listed.read_text().replace('    "mean": Family(', entry))
    assert "visualspeech.models.forest" in listed.read_text()
    assert changed(before, digests()) == set()


def test_a_new_kind_of_block_re_trains_nobody(package):
    before = digests()
    (package / "features" / "blocks" / "loudness.py").write_text("BLOCK = None\n")
    assert changed(before, digests()) == set()


def test_comments_and_docstrings_re_train_nobody(package):
    before = digests()
    edited(package, "models", "stack.py", text="\n# A comment.\n")
    text = (package / "models" / "stack.py").read_text()
    (package / "models" / "stack.py").write_text(text.replace('"""Outputs (B, T, N) of a batch."""', '"""Other."""'))
    assert changed(before, digests()) == set()


def test_predicting_and_training_depend_on_their_own_script(package):
    assert changed(digests(), digests(TRAIN.with_name("predict_model.py"))) == set(ROWS)


def test_features_depend_on_their_block_alone(package):
    def of_blocks():
        forget()
        script = TRAIN.with_name("encode_block.py")
        return {kind: provenance.code_digest(script, block_module(kind)) for kind in block_kinds()}

    before = of_blocks()
    edited(package, "features", "label_parts.py")
    assert changed(before, of_blocks()) == {"label_parts"}
    before = of_blocks()
    edited(package, "models", "stack.py")
    assert changed(before, of_blocks()) == set()


@pytest.mark.parametrize("module", ["dlib_tracker", "landmark_csv"])
def test_what_gives_landmarks_re_tracks_and_nothing_else(package, module):
    """Trackers are named and not imported: the pose follows from the landmarks, whoever gives them."""
    scripts = REPOSITORY / "workflow" / "scripts"

    def found():
        forget()
        tracking = provenance.code_digest(scripts / "track_landmarks.py", f"visualspeech.face.{module}")
        names = ("normalise_pose", "fit_head", "bundle_speaker", "speak_sentence")
        return tracking, [provenance.code_digest(scripts / f"{name}.py") for name in names]

    before = found()
    edited(package, "face", f"{module}.py")
    after = found()
    assert before[0] != after[0] and before[1] == after[1]
