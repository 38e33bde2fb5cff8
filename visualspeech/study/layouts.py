"""Layouts of the files of a study folder: JSON Schemas of ``study.json`` and ``key.json``, tables of the answers."""

from collections.abc import Mapping

from visualspeech.storage.layouts import TEXT

VERSION = 1
PREFERENCE, RATING = "preference", "rating"
PRACTICE, ITEM, ATTENTION = "practice", "item", "attention"
LEFT, NONE, RIGHT = "left", "none", "right"

#: Tables of a database of answers. ``presentations`` is what each participant sees, drawn when he or she starts.
TABLES = """
CREATE TABLE study (digest TEXT NOT NULL, simulated INTEGER NOT NULL);
CREATE TABLE participants (
    id INTEGER PRIMARY KEY, code TEXT NOT NULL UNIQUE, ticket TEXT NOT NULL UNIQUE, simulated INTEGER NOT NULL,
    started TEXT NOT NULL, consented TEXT NOT NULL, sound_checked TEXT, finished TEXT);
CREATE TABLE presentations (
    participant INTEGER NOT NULL REFERENCES participants(id), position INTEGER NOT NULL, item TEXT NOT NULL,
    mirrored INTEGER NOT NULL, opened REAL, PRIMARY KEY (participant, position), UNIQUE (participant, item));
CREATE TABLE answers (
    participant INTEGER NOT NULL REFERENCES participants(id), item TEXT NOT NULL, question TEXT NOT NULL,
    value TEXT NOT NULL, position INTEGER NOT NULL, mirrored INTEGER NOT NULL, played_to_end INTEGER NOT NULL,
    stored_at TEXT NOT NULL, UNIQUE (participant, item, question));
"""

_NAME = {"type": "string", "minLength": 1, "maxLength": 200}
_FILE = {"type": "string", "pattern": r"^[A-Za-z0-9]{1,64}\.(mp4|wav)\Z"}
_VALUE = {"anyOf": [_NAME, {"type": "integer"}]}


def _object(properties: Mapping, optional=()) -> dict:
    required = [name for name in properties if name not in optional]
    return {"type": "object", "additionalProperties": False, "required": required, "properties": dict(properties)}


def _list(items: Mapping, minimum: int = 1, maximum: int = 10_000) -> dict:
    return {"type": "array", "items": dict(items), "minItems": minimum, "maxItems": maximum}


_QUESTION = {
    "name": _NAME, "text": TEXT, "choices": _list({"enum": [LEFT, NONE, RIGHT]}, 0, 3), "minimum": {"type": "integer"},
    "maximum": {"type": "integer"}, "lowest": TEXT, "highest": TEXT,
}  # fmt: skip
_ITEM = {
    "id": {"type": "string", "pattern": r"^[A-Za-z0-9]{1,64}\Z"}, "role": {"enum": [PRACTICE, ITEM, ATTENTION]},
    "stimuli": _list(_FILE, 1, 2), "seconds": {"type": "number", "minimum": 0, "maximum": 3600},
}  # fmt: skip
_SOUND = _object({"stimulus": _FILE, "choices": _list(_NAME, 2, 20), "answer": _NAME})
STUDY_SCHEMA = _object({
    "version": {"const": VERSION}, "name": _NAME, "kind": {"enum": [PREFERENCE, RATING]}, "title": TEXT,
    "introduction": TEXT, "consent": TEXT, "questions": _list(_object(_QUESTION), 1, 100),
    "items": _list(_object(_ITEM)), "sound_check": {"anyOf": [{"type": "null"}, _SOUND]},
})  # fmt: skip
KEY_SCHEMA = _object({
    "version": {"const": VERSION}, "study": _NAME, "corpus": _NAME, "split": _NAME, "seed": {"type": "integer"},
    "published": TEXT,
    "conditions": _list(_object({"name": _NAME, "title": TEXT, "system": TEXT, "model": TEXT}), 1, 100),
    "stimuli": {
        "type": "object", "propertyNames": _FILE, "maxProperties": 20_000,
        "additionalProperties": _object({"item": _NAME, "utterance": _NAME, "conditions": _list(_NAME, 1, 2)}),
    },
    "expected": {
        "type": "object", "additionalProperties": {"type": "object", "additionalProperties": _VALUE},
    },
})  # fmt: skip
