"""The section of an evaluated viewing test in the report, from the folder of its evaluation."""

from pathlib import Path

from visualspeech.evaluation.gathering import shown_tables
from visualspeech.evaluation.report import Picture, StudySection
from visualspeech.evaluation.study_contents import read_contents

_FORMS = (".html", ".tsv", ".md", ".tex")


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
    folder, rows = Path(folder), read_contents(folder)
    title = next(text for kind, _, text in rows if kind == "title")
    page = next(file for kind, file, _ in rows if kind == "page")
    tables = [Path(folder, file) for kind, file, _ in rows if kind == "table"]
    return StudySection(
        title=title,
        page=Path(folder, page).relative_to(Path(report).parent).as_posix(),
        tables=shown_tables([[str(path.with_suffix(form)) for form in _FORMS] for path in tables], str(report)),
        figures=tuple(Picture(Path(folder, file).read_bytes(), text) for kind, file, text in rows if kind == "figure"),
    )
