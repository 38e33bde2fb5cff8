"""The public names of the library, and where each is defined.

A name is imported when it is first used, so that ``import visualspeech`` costs nothing and ``from visualspeech import
align`` loads no network. The modules are named and not imported: an import, even a late one, would put the whole
library into the digest of every job (:func:`visualspeech.provenance.code_digest`). ``visualspeech/__init__.pyi`` lists
the same names for type checkers and editors.
"""

from importlib import import_module

#: Public name -> module that defines it.
PUBLIC = {
    # Speech
    "align": "visualspeech.api.speech",
    "Alignment": "visualspeech.speech.alignment",
    "AlignmentSettings": "visualspeech.speech.alignment_settings",
    "Lexicon": "visualspeech.speech.lexicon",
    "write_textgrid": "visualspeech.speech.export",
    # Faces
    "track": "visualspeech.api.faces",
    "TrackedFace": "visualspeech.api.faces",
    "LandmarkSettings": "visualspeech.face.tracker",
    "ScreeningSettings": "visualspeech.face.screening",
    "fit_head": "visualspeech.api.faces",
    "normalise_pose": "visualspeech.api.faces",
    "NormalisedFace": "visualspeech.api.faces",
    "PoseSettings": "visualspeech.face.head",
    "sample_faces": "visualspeech.api.faces",
    "SampledFaces": "visualspeech.api.faces",
    "fit_aam": "visualspeech.api.faces",
    "Aam": "visualspeech.face.aam.model",
    "AamSettings": "visualspeech.face.aam.model_settings",
    "texture_image": "visualspeech.face.aam.reference",
    # Models
    "train": "visualspeech.api.learning",
    "predict": "visualspeech.api.learning",
    "load_model": "visualspeech.models.registry",
    "score": "visualspeech.api.scores",
    # Results of a run
    "Run": "visualspeech.api.runs",
    "System": "visualspeech.api.systems",
    "export_run": "visualspeech.api.exporting",
    # Talking head
    "Speaker": "visualspeech.api.speaker",
    "Said": "visualspeech.api.speaker",
    # Errors
    "VisualSpeechError": "visualspeech.errors",
    "SettingError": "visualspeech.errors",
    "DataError": "visualspeech.errors",
    "StorageError": "visualspeech.errors",
    "RejectedUtterance": "visualspeech.errors",
}


def public(name: str):
    """What a public name stands for; ``__all__`` is the list of all names.

    Raises
    ------
    AttributeError
        There is no such name.
    """
    if name == "__all__":
        return sorted(PUBLIC)
    if name not in PUBLIC:
        raise AttributeError(f"module 'visualspeech' has no attribute {name!r}")
    return getattr(import_module(PUBLIC[name]), name)
