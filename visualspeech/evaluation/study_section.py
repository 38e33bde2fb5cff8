"""The section of an evaluated viewing test in the report, from the folder of its evaluation."""

from pathlib import Path

from visualspeech.evaluation.forms import fragment_of
from visualspeech.evaluation.report import Picture, StudySection
from visualspeech.storage.files import read_text
from visualspeech.storage.tables import read_table

#: File of an evaluation that says what is shown: columns ``kind`` (title, page, table or figure), ``file``, ``text``.
CONTENTS = "contents.tsv"
COLUMNS = ("kind", "file", "text")


def study_section(folder: str | Path, report: str | Path) -> StudySection:
    """The section of a study.

    Parameters
    ----------
    folder : of its evaluation, below the folder of the report
    report : path of the page, to which links are relative

    Raises
    ------
    StorageError
        A file of the evaluation is missing or damaged.
    """
    folder = Path(folder)
    rows = list(read_table(folder / CONTENTS, COLUMNS, required=COLUMNS).itertuples(index=False))
    title = next(row.text for row in rows if row.kind == "title")
    page = next(row.file for row in rows if row.kind == "page")
    return StudySection(
        title=title,
        page=(folder / page).relative_to(Path(report).parent).as_posix(),
        tables=tuple(fragment_of(read_text(folder / row.file)) for row in rows if row.kind == "table"),
        figures=tuple(Picture((folder / row.file).read_bytes(), row.text) for row in rows if row.kind == "figure"),
    )
