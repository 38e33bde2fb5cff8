"""Visual speech: from recordings of a speaker to models, result tables and a talking head.

The public names, ``from visualspeech import align``, are listed in :mod:`visualspeech.api`; ``docs/library.md`` has an
example of each.
"""

__version__ = "0.1.0"

# This file is part of the digest of every job, with all that it imports. Therefore it imports nothing of the library,
# and the list of names is kept elsewhere.


def __getattr__(name: str):
    """A public name, which is imported when it is first used."""
    if name.startswith("_") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return import_module(f"{__name__}.api").public(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__getattr__("__all__")})
