"""The paths among the settings of a run: whether they are possible, and whether results would lie among inputs."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from visualspeech.speech.phone_sets import PRESETS

MAX_PATH, MAX_NAME = 4095, 255  # bytes, of a path and of each name in it
_BELOW = 600  # bytes that the paths of results are longer than the folder of the results


def path_mistakes(settings: Mapping) -> list[str]:
    """What is wrong with the paths of resolved settings, a sentence for each mistake; existence is not checked."""
    paths = [("results", settings["results"], MAX_PATH - _BELOW)]
    paths += [(where, path, MAX_PATH) for where, path in (*recording_folders(settings), *_files(settings))]
    impossible = [sentence for one in paths for sentence in _impossible(*one)]
    return impossible or _overlaps(settings)


def recording_folders(settings: Mapping) -> Iterator[tuple[str, str]]:
    """Place in the settings and path of the folders of recordings."""
    for name, corpus in settings["corpora"].items():
        if corpus["root"] and corpus["adapter"] != "demo":
            yield f"corpora.{name}.root", corpus["root"]
        elif corpus["adapter"] == "grid" and os.environ.get("GRID_ROOT"):
            yield "GRID_ROOT", os.environ["GRID_ROOT"]


def _files(settings: Mapping) -> Iterator[tuple[str, str]]:
    """Place in the settings and path of the files that a run reads beside the recordings."""
    for name, corpus in settings["corpora"].items():
        if corpus["table"] and corpus["adapter"] == "folder":
            yield f"corpora.{name}.table", str(Path(os.path.expanduser(corpus["root"]), corpus["table"]))
        aligned = corpus["alignment"]
        table = aligned["phones"] not in PRESETS and aligned["phones"]
        for key, path in (("folder", aligned["folder"]), ("dictionary", aligned["dictionary"]), ("phones", table)):
            if path:
                inside = os.path.join(os.path.expanduser(corpus["root"]), os.path.expanduser(path))
                yield f"corpora.{name}.alignment.{key}", inside if os.path.exists(inside) else path
    if settings["speak"]["file"]:
        yield "speak.file", settings["speak"]["file"]
    if settings["landmarks"]["folder"]:
        yield "landmarks.folder", settings["landmarks"]["folder"]
    for name, system in settings["systems"].items():
        if system["preference"]["answers"]:
            yield f"systems.{name}.preference.answers", system["preference"]["answers"]


def _impossible(where: str, path: str, most: int) -> list[str]:
    expanded = os.path.expanduser(path)
    names = [name for name in Path(expanded).parts if len(os.fsencode(name)) > MAX_NAME]
    if names:
        return [f"`{where}`: the name {names[0][:40]} ... has more than {MAX_NAME} bytes, too many for a file system."]
    if len(os.fsencode(os.path.abspath(expanded))) > most:
        return [f"`{where}`: the path has more than {most} bytes; give a shorter one."]
    if where.endswith(("root", "ROOT")) and path.startswith("~") and expanded == path:
        return [f"`{where}: {path[:80]}`: there is no user {path[1:].split('/')[0]!r}; write the path out."]
    return []


def _overlaps(settings: Mapping) -> list[str]:
    """Folders of recordings and files that this run's results would lie among, or that lie among them."""
    results = os.path.realpath(settings["results"])
    written = [os.path.join(results, name) for name in settings["corpora"]]
    found = []
    for where, path in recording_folders(settings):
        root = os.path.realpath(os.path.expanduser(path))
        if _holds(root, results) or any(_holds(folder, root) for folder in written):
            found.append(
                f"`{where}: {path}`: the results would be written among the recordings (`results` is {results}); set "
                "`results` to a folder outside, or put the recordings into a folder of their own."
            )
    for where, path in _files(settings):
        file = os.path.realpath(os.path.expanduser(path))
        if any(_holds(folder, file) for folder in written):
            found.append(f"`{where}: {path}` lies among the results, which replace files; copy it to another folder.")
    return found


def _holds(folder: str, path: str) -> bool:
    """Whether a path is a folder, or in it; both are real paths."""
    return os.path.commonpath((folder, path)) == folder
