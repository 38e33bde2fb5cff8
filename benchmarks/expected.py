"""Compares the figures of a run with the expected ones that the repository keeps, each within its tolerance.

Run: python -m benchmarks.expected RESULTS [--write]

RESULTS is the folder of a corpus (results/demo). Its tables/objective.tsv of every system is compared with
benchmarks/expected/<corpus>.tsv: prints a line for each figure that is missing or outside its tolerance, and a summary.
Exits with status 1 if there is any, or if the run was made from other data. --write makes the file from the run.

On the machine that the figures were written on they come out the same to the last digit. Other processors round
differently, and the training of networks amplifies that. So the tolerance is 0.5 % of the figure for rows without
random training (baselines, HMMs, reconstruction) and 2 % for networks; 0.005 and 0.02 for correlations; but at least
one unit of the last digit.
"""

import argparse
import csv
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

from visualspeech.errors import StorageError, VisualSpeechError
from visualspeech.evaluation.metrics import METRICS
from visualspeech.models.families import FAMILIES
from visualspeech.storage.files import read_text, write_text
from visualspeech.storage.models import read_model_settings

FOLDER = Path(__file__).with_suffix("")
COLUMNS = ("corpus", "system", "row", "metric", "value", "tolerance")
LIBRARIES = ("torch", "numpy")

#: Facts of a system's table that the header of a file of expected figures repeats.
SYSTEM_FACTS = ("rate", "visual coding", "drift removal", "seeds", "test utterances", "test frames", "visualspeech")

#: Share of a figure, of rows without random training and of networks; for correlations absolute.
RELATIVE, RELATIVE_NETWORK = 0.005, 0.02
ABSOLUTE, ABSOLUTE_NETWORK = 0.005, 0.02
CORRELATIONS = ("corr", "ccc")

_ROUNDING = 1e-9  # of the decimal figures in binary


class Figure(NamedTuple):
    """What a figure is of."""

    system: str
    row: str
    metric: str


@dataclass(frozen=True)
class Expected:
    """Figures of the systems of a corpus.

    Parameters
    ----------
    corpus : its name
    split : digest of the split of its utterances
    facts : (system, name) -> text: what the figures of a system were computed on
    figures : value as the table shows it
    tolerances : largest accepted difference
    """

    corpus: str
    split: str
    facts: Mapping[tuple[str, str], str]
    figures: Mapping[Figure, str]
    tolerances: Mapping[Figure, float]

    @property
    def systems(self) -> tuple[str, ...]:
        """The systems that have figures."""
        return tuple(dict.fromkeys(figure.system for figure in self.figures))


@dataclass(frozen=True)
class Comparison:
    """How figures compare with expected ones.

    Parameters
    ----------
    deviations : a line for each figure that is missing or outside its tolerance
    remarks : sentences about rows that differ, and about facts that explain deviations
    equal : number of figures that are equal as shown
    """

    deviations: tuple[str, ...]
    remarks: tuple[str, ...]
    equal: int


def read_run(results: Path) -> Expected:
    """The figures of all systems of a corpus's folder, with the tolerances that are written for them.

    Raises
    ------
    StorageError
        There is no result table, or the tables are of different splits.
    """
    tables = sorted(results.glob("*/tables/objective.tsv"))
    if not tables:
        raise StorageError(
            f"{results} holds no <system>/tables/objective.tsv. Give the folder of a corpus of a finished run, for "
            "example results/demo."
        )
    facts: dict[tuple[str, str], str] = {}
    figures: dict[Figure, str] = {}
    tolerances: dict[Figure, float] = {}
    splits = {}
    for path in tables:
        system = path.parents[1].name
        header, rows = _read(path)
        splits[system] = header.get("split", "")
        facts |= {(system, name): header[name] for name in SYSTEM_FACTS if name in header}
        for row in rows:
            network = _is_network(path.parents[1] / "models" / row["row"] / "model.safetensors")
            for metric in METRICS:
                if row.get(metric):
                    figure = Figure(system, row["row"], metric)
                    figures[figure] = row[metric]
                    tolerances[figure] = tolerance(metric, row[metric], network)
    if len(set(splits.values())) > 1:
        raise StorageError(f"the systems of {results} are of different splits ({splits}). Run the workflow again.")
    return Expected(results.resolve().name, next(iter(splits.values())), facts, figures, tolerances)


def tolerance(metric: str, value: str, network: bool) -> float:
    """Largest accepted difference from a figure, in units of the figure; at least one unit of its last digit."""
    if metric.removesuffix("_absolute") in CORRELATIONS:
        accepted = ABSOLUTE_NETWORK if network else ABSOLUTE
    else:
        accepted = abs(float(value)) * (RELATIVE_NETWORK if network else RELATIVE)
    digits = len(value.partition(".")[2])
    return max(accepted, 10.0**-digits)


def _is_network(model: Path) -> bool:
    """Whether a model was trained by the training loop; a row without a model (reconstruction) was not."""
    return model.is_file() and FAMILIES[read_model_settings(model)["family"]].trained


def write_expected(path: Path, found: Expected) -> None:
    """Write the figures of a run as a file of expected figures."""
    header = [("corpus", found.corpus), ("split", found.split)]
    header += [(f"{system} {name}", text) for (system, name), text in found.facts.items()]
    header += [("written with", ", ".join(f"{name} {version(name)}" for name in LIBRARIES))]
    header += [
        (
            "tolerance",
            f"{100 * RELATIVE:g} % of the value ({100 * RELATIVE_NETWORK:g} % for networks), correlations {ABSOLUTE:g} "
            f"({ABSOLUTE_NETWORK:g}); at least one unit of the last digit",
        ),
        (
            "why",
            "on one machine the figures come out equal to the last digit; other processors round differently, and the "
            "training of networks amplifies that",
        ),
    ]
    lines = [f"# {name}: {text}" for name, text in header]
    lines.append("\t".join(COLUMNS))
    for figure, value in found.figures.items():
        lines.append("\t".join((found.corpus, *figure, value, f"{found.tolerances[figure]:.6g}")))
    write_text(path, "\n".join(lines) + "\n")


def read_expected(path: Path) -> Expected:
    """The figures of a file of expected figures.

    Raises
    ------
    StorageError
        There is no such file, or it is none.
    """
    if not path.is_file():
        known = ", ".join(sorted(one.stem for one in path.parent.glob("*.tsv"))) or "none"
        raise StorageError(f"there are no expected figures of {path.stem}. Known: {known}; --write makes them.")
    header, rows = _read(path)
    if any(set(row) != set(COLUMNS) for row in rows):
        raise StorageError(f"{path} is no file of expected figures: its columns are not {', '.join(COLUMNS)}.")
    figures = {Figure(row["system"], row["row"], row["metric"]): row for row in rows}
    systems = {figure.system for figure in figures}
    facts = {
        (system, name): text
        for key, text in header.items()
        for system, _, name in (key.partition(" "),)
        if system in systems and name
    }
    return Expected(
        path.stem,
        header.get("split", ""),
        facts,
        {figure: row["value"] for figure, row in figures.items()},
        {figure: float(row["tolerance"]) for figure, row in figures.items()},
    )


def compare(expected: Expected, found: Expected) -> Comparison:
    """Compare the figures of a run with the expected ones."""
    remarks = []
    for system in expected.systems:
        wanted, there = (
            {figure.row for figure in given.figures if figure.system == system} for given in (expected, found)
        )
        if missing := sorted(wanted - there):
            remarks.append(f"{system}: the run lacks the rows {', '.join(missing)}.")
        if further := sorted(there - wanted):
            remarks.append(f"{system}: no figures are expected of the rows {', '.join(further)}.")
        for name in SYSTEM_FACTS:
            texts = [given.facts.get((system, name), "") for given in (expected, found)]
            if there and texts[0] and texts[0] != texts[1]:
                remarks.append(f"{system}: {name} is {texts[1] or 'not given'}; expected {texts[0]}.")
    deviations, equal = [], 0
    for figure, value in expected.figures.items():
        name = f"{figure.system} {figure.row} {figure.metric}"
        if figure not in found.figures:
            deviations.append(f"{name}: missing; expected {value}")
            continue
        here = found.figures[figure]
        difference, accepted = float(here) - float(value), expected.tolerances[figure]
        equal += here == value
        if not abs(difference) <= accepted + _ROUNDING:
            deviations.append(f"{name}: {here}; expected {value} ± {accepted:.3g}")
    return Comparison(tuple(deviations), tuple(remarks), equal)


def _read(path: Path) -> tuple[dict[str, str], list[dict[str, str]]]:
    """Header (lines ``# name: text``) and rows of a TSV file, all as text."""
    lines = read_text(path).splitlines()
    header = dict(line[1:].strip().partition(": ")[::2] for line in lines if line.startswith("#"))
    rows = list(csv.DictReader((line for line in lines if not line.startswith("#")), delimiter="\t"))
    return header, rows


def main(results: Path, write: bool = False, folder: Path = FOLDER) -> int:
    """Compare a run with the expected figures, or write them; returns the exit status.

    Parameters
    ----------
    results : folder of a corpus
    write : write the expected figures
    folder : holds the files of expected figures
    """
    corpus = results.resolve().name
    path, found = folder / f"{corpus}.tsv", read_run(results)
    if write:
        write_expected(path, found)
        print(f"{len(found.figures)} figures of {', '.join(found.systems)} written to {path}")
        return 0
    expected = read_expected(path)
    if found.split != expected.split:
        print(
            f"{results} was made from other data: its split is {found.split}, that of the expected figures "
            f"{expected.split}. Nothing was compared."
        )
        return 1
    comparison = compare(expected, found)
    for line in (*comparison.remarks, *comparison.deviations):
        print(line)
    failed = len(comparison.deviations)
    print(
        f"{len(expected.figures)} expected figures: {len(expected.figures) - failed} within their tolerance "
        f"({comparison.equal} of them equal), {failed} outside or missing"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.expected", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("results", type=Path, help="folder of a corpus, for example results/demo")
    parser.add_argument("--write", action="store_true", help="make the file of expected figures from this run")
    given = parser.parse_args()
    try:
        sys.exit(main(given.results, given.write))
    except VisualSpeechError as error:
        sys.exit(str(error))
