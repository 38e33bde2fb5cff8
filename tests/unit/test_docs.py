"""The documents say what is there: settings, targets, links, modules and functions that they name."""

import ast
import re
import shlex

import pytest
import yaml

from tests.paths import REPOSITORY
from visualspeech.evaluation.metrics import METRICS
from visualspeech.planning.run import resolve
from visualspeech.settings import merged, read_yaml

CONFIG = REPOSITORY / "config"
DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *REPOSITORY.glob("docs/*.md"), *REPOSITORY.glob("config/*.md")])
#: Options of snakemake that take the arguments after them.
TAKE_VALUES = ("--cores", "--configfile", "--config", "--directory", "--snakefile", "--report", "--profile")
#: Placeholders of a file name.
HOLES = "<{*"


def fenced(language: str):
    """Fenced code blocks of a language in all documents: document and line, text."""
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        for block in re.finditer(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            line = text[: block.start()].count("\n") + 1
            yield pytest.param(block[1], id=f"{document.relative_to(REPOSITORY)}:{line}")


def is_run(text: str) -> bool:
    """Whether a block is an overlay of the run's settings, not a fragment of a system or of a coding."""
    given = yaml.safe_load(text)
    return isinstance(given, dict) and set(given) <= set(read_yaml(CONFIG / "config.yaml"))


def commands(text: str):
    """The command lines of a shell block, comments and continuation lines resolved."""
    for line in text.replace("\\\n", " ").splitlines():
        for part in re.split(r"&&|\|", line):
            words = shlex.split(part, comments=True)
            names = [word.rpartition("/")[2] for word in words]
            if "snakemake" in names:
                yield words[names.index("snakemake") + 1 :]


def arguments(words: list[str]) -> tuple[list[str], list[str]]:
    """Targets and overlays of a snakemake command line."""
    targets, overlays, option = [], [], ""
    for word in words:
        if word.startswith("-"):
            option = word
        elif "=" in word:
            continue  # of --config or --default-resources
        elif option == "--configfile":
            # Snakemake takes every word up to the next option for a file: targets must stand before.
            overlays.append(word)
        elif option in TAKE_VALUES:
            option = ""
        else:
            targets.append(word)
    return targets, overlays


# The examples of config/README.md are resolved by test_settings.py, which gives them the files that they name.
OVERLAYS = [one for one in fenced("yaml") if is_run(one.values[0]) and not one.id.startswith("config/")]


def modules() -> dict[str, str]:
    """Python files of the documents that begin with their name, such as ``# jaw.py``."""
    named = (re.match(r"# (\w+\.py)\n", one.values[0]) for one in fenced("python"))
    return {one[1]: one.string for one in named if one}


@pytest.mark.parametrize("text", OVERLAYS)
def test_settings_resolve(text, tmp_path, monkeypatch):
    for name, source in modules().items():
        (tmp_path / name).write_text(source)
    monkeypatch.chdir(tmp_path)
    resolve(merged(read_yaml(CONFIG / "config.yaml"), yaml.safe_load(text)), CONFIG)


def test_every_measure_is_listed():
    """In the list of config/README.md, those of regions by that of one region."""
    text = (CONFIG / "README.md").read_text(encoding="utf-8")
    listed = re.search(
        r"^Measures of a visual coding of the kind `aam`: (.*?)\. Of `markers`: (.*?)\. ", text, re.M | re.S
    )
    whole, regional = (re.findall(r"`(\w+)`", part) for part in listed.groups())
    assert whole == [name for name, metric in METRICS.items() if not metric.region]
    of_upper = [name for name, metric in METRICS.items() if metric.region == "upper"]
    assert [name for name in regional if "_upper" in name] == of_upper


def in_comments():
    """Command lines in the comments of the configuration."""
    for path in sorted(CONFIG.rglob("*.yaml")):
        for line in re.findall(r"^#.*(snakemake --.*)", path.read_text(encoding="utf-8"), re.MULTILINE):
            yield pytest.param(line, id=path.relative_to(REPOSITORY).as_posix())


@pytest.mark.parametrize("text", [*fenced("sh"), *in_comments()])
def test_targets_and_overlays_exist(text):
    rules = set(re.findall(r"^rule (\w+):", (REPOSITORY / "Snakefile").read_text(), re.MULTILINE))
    own = set(re.findall(r"^# (\w+\.yaml)$", "\n".join(path.read_text() for path in DOCUMENTS), re.MULTILINE))
    for words in commands(text):
        targets, overlays = arguments(words)
        assert {one for one in targets if not one.startswith("results/")} <= rules
        assert all((REPOSITORY / one).is_file() or one in own for one in overlays)


def test_named_targets_exist():
    """Targets that stand in running text as ``snakemake --cores 2 NAME``, or in the list of stages of the README."""
    rules = set(re.findall(r"^rule (\w+):", (REPOSITORY / "Snakefile").read_text(), re.MULTILINE))
    text = "\n".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
    assert set(re.findall(r"`(?:\S*/)?snakemake --cores \d+ (\w+)", text)) <= rules
    stages = re.search(r"stops after one stage: (.*?)\.\s", (REPOSITORY / "README.md").read_text(), re.DOTALL)
    assert set(re.findall(r"`(\w+)`", stages[1])) <= rules


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(REPOSITORY).as_posix())
def test_links_and_paths_resolve(document):
    text = document.read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text) if "://" not in link]
    assert [link for link in links if not (document.parent / link).exists()] == []
    # Of the changelog, which names files of the past, links alone.
    roots = ("visualspeech/", "workflow/", "config/", "docs/", "tests/", "benchmarks/", "profiles/")
    paths = [path for path in re.findall(r"`([\w./<>{}*-]+)`", text) if path.startswith(roots)]
    paths = [path for path in paths if not set(HOLES) & set(path)] if document.name != "CHANGELOG.md" else []
    assert [path for path in paths if not (REPOSITORY / path).exists()] == []
    modules = re.findall(r"python -m (benchmarks\.\w+)", text)
    assert [name for name in modules if not (REPOSITORY / f"{name.replace('.', '/')}.py").is_file()] == []


def defined(path) -> set[str]:
    """Names of the functions and classes of a module, methods as ``Class.method``."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{inner.name}" for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return found


def rows_of_papers():
    text = (REPOSITORY / "docs" / "papers.md").read_text(encoding="utf-8")
    for modules, functions in re.findall(r"\| (`visualspeech/[^|]*) \| ([^|]*) \|$", text, re.MULTILINE):
        yield pytest.param(modules, functions, id=f"{modules} {functions}".replace("`", ""))


@pytest.mark.parametrize(("modules", "functions"), list(rows_of_papers()))
def test_what_papers_names_is_defined(modules, functions):
    names, first = set(), None
    for name in re.findall(r"`([^`]+)`", modules):
        # A further file of a cell lies beside the first.
        path = REPOSITORY / name if name.startswith("visualspeech/") else first.parent / name
        first = first or path
        assert path.is_file(), path
        names |= defined(path) if path.suffix == ".py" else set()
    assert set(re.findall(r"`([^`]+)`", functions)) <= names
