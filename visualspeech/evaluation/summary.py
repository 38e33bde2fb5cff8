"""The last lines of a run: its report, its best models, what was left out, and what to do next."""

import os
import shlex
import shutil
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from visualspeech.corpora.findings import UNLISTED, read_findings, rejected_ids
from visualspeech.evaluation.conclusions import choose
from visualspeech.models.rows import ModelRow
from visualspeech.progress import Failed
from visualspeech.storage.tables import read_numbers

WIDTH, INDENT = 100, 18
#: Most words that are listed.
MOST_WORDS = 10
#: Options that would make everything again.
FORCING = ("-F", "--forceall", "-f", "--force", "--touch", "-t")


def finished(corpora: Sequence[Mapping], following: Sequence[str]) -> list[str]:
    """Lines for a run that has ended well; what its target did not make is left out.

    Parameters
    ----------
    corpora : of each its ``name``, the paths ``report`` and ``findings`` (a list), the number ``utterances``, and
        ``systems``: ``name``, ``rows`` (plain data), ``validation`` (name of a row -> path of its statistics)
    following : commands to type next
    """
    several = len(corpora) > 1
    lines = _line("Report", [one["report"] for one in corpora if Path(one["report"]).is_file()])
    best = [_best(one, several) for one in corpora]
    lines += _line("Best model", [part for parts in best for part in parts], "by the validation utterances")
    left = [_rejected(one, several) for one in corpora]
    lines += _line("Rejected", [part for part in left if part])
    known = [one for one in corpora if _found(one)]
    words = list(dict.fromkeys(word for one in known for word in guessed_words(one["findings"])))
    lines += _line("Guessed words", [_listed(words)] if known else [])
    return lines + [start.ljust(INDENT) + one for start, one in zip(("Next:", *[""] * 9), following, strict=False)]


def failed(jobs: Sequence[Failed], done: int, total: int) -> list[str]:
    """Lines for a run that has failed or was stopped: which jobs, what they said, their logs, and what to do.

    Parameters
    ----------
    jobs : that failed
    done, total : numbers of jobs
    """
    jobs = [job for job in jobs if not job.message().startswith("stopped")]  # they ended with the run
    count = f"{done} of {total} jobs are done. " if total else ""
    if not jobs:
        return [f"The run was stopped. {count}Run the same command again to resume."]
    lines = [f"The run failed in {jobs[0]}." if len(jobs) == 1 else f"The run failed in {len(jobs)} jobs."]
    for job in jobs[:5]:
        lines += [f"  {job}:"] if len(jobs) > 1 else []
        lines += [f"  {line}" for line in (job.message() or "Its message is above.").splitlines()]
        lines += [f"  Log: {path}" for path in job.logs]
    lines += [f"  and {len(jobs) - 5} further jobs"] if len(jobs) > 5 else []
    return [*lines, f"{count}When this is corrected, run the same command again: what is done is kept."]


def guessed_words(findings: Sequence[str]) -> list[str]:
    """Words that the pronunciation dictionary does not list, from tables of findings; those missing are passed over."""
    said = [one.finding for one in read_findings(*filter(_is_file, findings)) if one.finding.startswith(UNLISTED)]
    return list(dict.fromkeys(word for one in said for word in one.removeprefix(UNLISTED).split(", ")))


def _best(corpus: Mapping, several: bool) -> list[str]:
    """The best model of each system by the validation utterances, as the report has it."""
    found = []
    for system in corpus["systems"]:
        files = {name: path for name, path in system["validation"].items() if _is_file(path)}
        rows = [row for row in map(ModelRow.of, system["rows"]) if row.name in files]
        validation = {row.name: read_numbers(files[row.name]) for row in rows if row.role == "model"}
        if choice := choose(rows, validation):
            place = f"{corpus['name']}/{system['name']}" if several else system["name"]
            found.append(f"{place} {choice.best} ({choice.metric.title})")
    return found


def _rejected(corpus: Mapping, several: bool) -> str:
    if not _found(corpus):
        return ""
    count = len(rejected_ids(read_findings(*filter(_is_file, corpus["findings"]))))
    place = f" of {corpus['name']}" if several else ""
    see = f", see {corpus['findings'][0]}" if count else ""
    return f"{count} of {corpus['utterances']} utterances{place}{see}"


def _found(corpus: Mapping) -> bool:
    return any(map(_is_file, corpus["findings"]))


def _is_file(path: str) -> bool:
    return bool(path) and Path(path).is_file()


def _listed(words: Sequence[str]) -> str:
    if not words:
        return "none"
    more = f" and {len(words) - MOST_WORDS} more" if len(words) > MOST_WORDS else ""
    return f"{len(words)} ({', '.join(words[:MOST_WORDS])}{more}), pronounced by letter-to-sound rules"


def _line(heading: str, parts: Sequence[str], note: str = "") -> list[str]:
    """One line with all parts, or one for each where they are too long for one."""
    if not parts:
        return []
    start = f"{heading}:".ljust(INDENT)
    whole = "; ".join(parts) + (f", {note}" if note else "")
    if len(start + whole) <= WIDTH or len(parts) == 1:
        return [start + whole]
    return [start + (note or parts[0]), *(" " * INDENT + part for part in (parts if note else parts[1:]))]


def speak_commands(folder: str, made: bool, arguments: Sequence[str], targets: Collection[str]) -> list[str]:
    """What to type to let the head speak.

    Parameters
    ----------
    folder : speaker folder
    made : whether it is there; otherwise the first command makes it
    arguments, targets : command line of the run, and its targets, in whose place that command has ``speaker``
    """
    program, *words = arguments
    before = _before(program)
    name = "python -m snakemake" if Path(program).name == "__main__.py" else f"{before}snakemake"
    forced, rest = False, []
    for word in words:
        forced = word in ("-R", "--forcerun") or (forced and not word.startswith("-"))  # they take the words after them
        if not forced and word not in targets and word not in FORCING:
            rest.append(word)
    say = f'{before}visualspeech speak --model {shlex.quote(folder)} --text "Hello." -o hello.mp4'
    return [say] if made else [shlex.join([*name.split(), "speaker", *rest]), say]


def study_commands(folders: Sequence[str], arguments: Sequence[str]) -> list[str]:
    """What to type to show each viewing test to viewers, and then to evaluate their answers."""
    before = _before(arguments[0])
    names = [shlex.quote(folder) for folder in folders]
    evaluated = names[0] if len(names) == 1 else "FOLDER"
    return [
        *(f"{before}visualspeech study serve {name}" for name in names),
        *([f"{before}visualspeech study evaluate {evaluated}"] if names else []),
    ]


def _before(program: str) -> str:
    """What a command begins with where it is typed as .venv/bin/snakemake, with its folder not on the path."""
    return "" if shutil.which("snakemake") else f"{os.path.relpath(Path(program).parent)}/"
