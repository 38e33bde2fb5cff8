"""Evaluates a viewing test: reads a study folder and its answers, and writes tables, figures and one page."""

import base64
import html
from dataclasses import dataclass
from pathlib import Path

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.forms import PAGE_STYLE, all_forms, to_html
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.study_contents import COLUMNS, CONTENTS
from visualspeech.storage.files import replacing
from visualspeech.storage.tables import table_text
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.evaluation_tables import Context, Drawing, Part, participants_part
from visualspeech.study.exclusion import Screening, screen
from visualspeech.study.layouts import PREFERENCE
from visualspeech.study.preference_tables import compare_conditions, preference_drawings, preference_parts
from visualspeech.study.rating_tables import judge_conditions, rating_drawings, rating_parts
from visualspeech.study.records import (
    ANSWERS,
    SIMULATED_ANSWERS,
    read_answers,
    read_key,
    read_participants,
    read_study,
)

#: Suffixes of the files of a table, in the order of :func:`visualspeech.evaluation.forms.all_forms`.
FORMS = (".tsv", ".md", ".tex", ".html")
#: The page that shows everything.
PAGE = "evaluation.html"
#: Parts that the command shows in the terminal.
SUMMARY = ("preference", "ratings", "rating_tests")
#: Folder of the results in a study folder.
FOLDER, SIMULATED_FOLDER = "evaluation", "evaluation.simulated"


@dataclass(frozen=True)
class Evaluation:
    """The evaluation of a study.

    Parameters
    ----------
    title : of the page
    simulated : whether the answers are
    parts : tables, the main one first
    drawings : figures
    screening : who is counted
    """

    title: str
    simulated: bool
    parts: tuple[Part, ...]
    drawings: tuple[Drawing, ...]
    screening: Screening


def evaluate(folder: str | Path, simulated: bool = False, settings: EvaluationSettings | None = None) -> Evaluation:
    """Evaluate the answers of people, or the simulated ones, to a study.

    Raises
    ------
    StorageError
        A file of the study is missing or damaged.
    DataError
        Files do not belong together, there is no answer, or no participant counts.
    """
    settings = settings or EvaluationSettings()
    study, key = read_study(folder), read_key(folder)
    path = Path(folder, SIMULATED_ANSWERS if simulated else ANSWERS)
    # In this order: whoever answers first while a server runs is then among the participants.
    try:
        answers = read_answers(folder, simulated)
    except (TypeError, ValueError) as error:
        raise DataError(
            f"{path} holds a rating that is no number. The file was edited: restore it from a copy, or move it away."
        ) from error
    participants = read_participants(folder, simulated)
    if not answers:
        raise DataError(_no_answers(folder, path, simulated, len(participants)))
    screening = screen(study, key, participants, answers, settings, str(path))
    if not screening.counted:
        raise DataError(_nobody_counts(path, screening))
    context = Context(study, key, screening, settings, simulated)
    paper = published(key.published)
    if study.kind == PREFERENCE:
        compared = compare_conditions(context)
        parts = preference_parts(context, compared, paper)
        drawings = preference_drawings(context, compared, paper)
    else:
        judged = judge_conditions(context)
        parts, drawings = rating_parts(context, judged, paper), rating_drawings(context, judged)
    title = context.titled(f"viewing test {study.name}") if simulated else f"Viewing test {study.name}"
    return Evaluation(title, simulated, (*parts, participants_part(context)), drawings, screening)


def _no_answers(folder: str | Path, path: Path, simulated: bool, participants: int) -> str:
    begun = f"; {participants} participants have begun" if participants else ""
    if simulated:
        return (
            f"{folder} holds no simulated answers ({path.name}){begun}. `visualspeech study simulate {folder}` makes "
            "them; without --simulated the answers of people are evaluated."
        )
    rehearsed = (
        " There are simulated answers, which --simulated evaluates."
        if Path(folder, SIMULATED_ANSWERS).is_file()
        else ""
    )
    return (
        f"{folder} holds no answers of people yet ({path.name}){begun}. Run the study with `visualspeech study serve "
        f"{folder}` and evaluate it afterwards.{rehearsed}"
    )


def _nobody_counts(path: Path, screening: Screening) -> str:
    reasons = [one.reason for one in screening.participations]
    counts = ", ".join(f"{reasons.count(name)} {name}" for name in dict.fromkeys(reasons))
    return (
        f"{path}: none of the {len(reasons)} participants counts ({counts}). {screening.rule} Wait for more "
        "participants, or allow more failed attention items (`max_failed_attention`)."
    )


def summary(evaluation: Evaluation) -> str:
    """The main tables as lines of plain text: their titles and rows, and the facts of the first one."""
    main = [table for part in evaluation.parts if part.name in SUMMARY for table in part.tables]
    lines = []
    for table in main:
        lines.append(table.title)
        for row in table.rows:
            cells = zip(table.columns, row.cells, strict=True)
            texts = (f"{name} {cell.text} {cell.small}".rstrip() for name, cell in cells if cell.text)
            lines.append(f"  {row.title}: {', '.join(texts)}")
        facts = table.facts if table is main[0] else [one for one in table.facts if one[0] == "source"]
        lines += [f"  {name}: {text}" for name, text in facts if name not in ("visualspeech", "split")]
    return "\n".join(lines)


def default_folder(folder: str | Path, simulated: bool) -> Path:
    """Where the results of a study folder are written unless another folder is given."""
    return Path(folder, SIMULATED_FOLDER if simulated else FOLDER)


def write_evaluation(folder: str | Path, evaluation: Evaluation) -> None:
    """Write all tables and figures, and a page that shows them, into a folder that appears whole.

    Raises
    ------
    SettingError
        The folder holds other files, which would be lost.
    StorageError
        It cannot be written.
    """
    folder = Path(folder)
    texts = evaluation_files(evaluation)
    check_folder(folder)
    with replacing(folder) as temporary:
        temporary.mkdir()
        for name, content in texts.items():
            Path(temporary, name).write_bytes(content)


def check_folder(folder: str | Path) -> None:
    """Refuse a folder that holds anything but an earlier evaluation; raises as :func:`write_evaluation`."""
    folder = Path(folder)
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise SettingError(f"{folder} is a file or a link; give the name of a folder for the evaluation.")
    if folder.is_dir() and any(folder.iterdir()) and not Path(folder, PAGE).is_file():
        raise SettingError(f"{folder} holds other files, which the evaluation would replace; give another folder.")


def evaluation_files(evaluation: Evaluation) -> dict[str, bytes]:
    """Name of a file -> its content."""
    files: dict[str, bytes] = {}
    for part in evaluation.parts:
        for suffix, text in zip(FORMS, all_forms(part.frame, part.tables, part.title), strict=True):
            files[part.name + suffix] = text.encode("utf-8")
    for one in evaluation.drawings:
        files[f"{one.name}.png"] = one.picture.png
    files[PAGE] = _page(evaluation).encode("utf-8")
    files[CONTENTS] = _contents(evaluation).encode("utf-8")
    return files


def _contents(evaluation: Evaluation) -> str:
    """What the report shows, and in which order."""
    import pandas

    rows = [("title", "", evaluation.title), ("page", PAGE, "")]
    rows += [("figure", f"{one.name}.png", one.picture.caption) for one in evaluation.drawings]
    rows += [("table", f"{part.name}.html", part.title) for part in evaluation.parts]
    return table_text(pandas.DataFrame(rows, columns=list(COLUMNS)))


def _page(evaluation: Evaluation) -> str:
    """All tables and figures on one page without links."""
    title = html.escape(evaluation.title)
    lines = [
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; img-src data:; '
        "style-src 'unsafe-inline'\">",
        f"<title>{title}</title><style>{PAGE_STYLE}img{{max-width:100%;background:#fff}}figure{{margin:1.5rem 0}}"
        "</style></head><body>",
        f"<h1>{title}</h1>",
    ]
    main, *rest = evaluation.parts
    lines.append(to_html(main.tables))
    for one in evaluation.drawings:
        caption, data = html.escape(one.picture.caption), base64.b64encode(one.picture.png).decode("ascii")
        lines.append(
            f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption>'
            "</figure>"
        )
    lines += [to_html(part.tables) for part in rest]
    return "\n".join([*lines, "</body></html>\n"])
