"""Table 3 of Fan et al. (2015): the hidden Markov models against the best network, and how sure that is."""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.comparisons import ComparisonSettings, holm, paired_p
from visualspeech.evaluation.metrics import METRICS, sums
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.sheets import Cell, Sheet
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample
from visualspeech.evaluation.table_formats import column_title, row_title
from visualspeech.evaluation.topologies import PAPER_METRICS
from visualspeech.naming import cells_of, parse_name

HMM_PREFIX = "hmm_"
COLUMNS = ("source", "system", "metric", "value", "low", "high", "gain", "gain_low", "gain_high", "p", "p_holm")


def best_network(curves: Mapping[str, object]) -> str:
    """The network with a B layer and the lowest validation error, named without its seed.

    The test utterances have no say in it, so that the best of many is not judged by what it was chosen by. The lowest
    errors of the seeds of one network are averaged.

    Parameters
    ----------
    curves : name of a network -> its learning curve (data frame with the column ``validation``)

    Raises
    ------
    DataError
        No network has a B layer and the plain labels.
    """
    errors = {
        cell: float(np.mean([curves[name]["validation"].min() for name in names]))
        for cell, names in cells_of(curves).items()
        if "B" in parse_name(cell).letters and not parse_name(cell).rich
    }
    if not errors:
        raise DataError("no network with a BLSTM layer was trained. Add one to `networks.stacks`, for example FBB.")
    return min(errors, key=errors.get)


def system_frame(
    tables: Mapping[str, object],
    network: str,
    paper: Published | None = None,
    settings: ComparisonSettings | None = None,
    bootstrap: BootstrapSettings | None = None,
):
    """Figures of the HMMs and of one network as a data frame with :data:`COLUMNS`, a line a system and measure.

    ``gain`` is what the network gains over an HMM: of an error the share by which it is lower (``1 - network / HMM``),
    of CORR the difference. Its interval is drawn in pairs. P values are Holm-corrected over all lines. Rows of the
    published table have a gain and nothing else.

    Parameters
    ----------
    tables : row name -> per-utterance table, seeds pooled; rows whose name begins with ``hmm_`` are the HMMs
    network : the row that they are compared with
    """
    import pandas

    settings, bootstrap = settings or ComparisonSettings(), bootstrap or BootstrapSettings()
    hmms = [row for row in tables if row.startswith(HMM_PREFIX)]
    lines, p = [], []
    drawn = draws(len(tables[network]), bootstrap)
    if any(list(tables[row]["id"]) != list(tables[network]["id"]) for row in hmms):
        raise DataError("networks and HMMs were evaluated on different utterances. Delete the models and run again.")
    for system in (*hmms, network):
        for metric in map(METRICS.get, PAPER_METRICS):
            own, best = (sums(tables[row], metric) for row in (system, network))
            sampled, against = sample(*own, drawn), sample(*best, drawn)
            shown = figure(sampled, bootstrap.level)
            gain = (np.nan,) * 3
            if system != network:
                found = figure(_gain(metric.best, against, sampled), bootstrap.level)
                gain = (found.value, found.low, found.high)
                p.append(paired_p(metric, best, own, settings))
            lines.append(("ours", system, metric.name, shown.value, shown.low, shown.high, *gain))
    missing = [np.nan] * len(PAPER_METRICS)
    tested = [[*values, *missing] for values in (p, holm(np.array(p)))]
    frame = pandas.DataFrame(lines, columns=list(COLUMNS[:9])).assign(p=tested[0], p_holm=tested[1])
    return frame if paper is None else pandas.concat([frame, _published_frame(paper)], ignore_index=True)


def _gain(best: str, network: Sampled, hmm: Sampled) -> Sampled:
    if best == "low":
        return Sampled(1 - network.value / hmm.value, 1 - network.samples / hmm.samples)
    return Sampled(network.value - hmm.value, network.samples - hmm.samples)


def _published_frame(paper: Published):
    import pandas

    hmm, network = paper.systems["HMM"], paper.systems["deep BLSTM"]
    lines = []
    for system, figures in paper.systems.items():
        for metric, value in figures.items():
            gain = np.nan
            if figures is hmm:
                low = METRICS[metric].best == "low"
                gain = 1 - network[metric] / value if low else network[metric] - value
            lines.append({"source": "published", "system": system, "metric": metric, "value": value, "gain": gain})
    return pandas.DataFrame(lines, columns=list(COLUMNS)).astype({name: float for name in COLUMNS[3:]})


def system_sheets(
    frame, network: str, facts: Sequence[tuple[str, str]], paper: Published | None, settings: ComparisonSettings,
    digits: int = 3,
) -> tuple[Sheet, ...]:  # fmt: skip
    """Table 3 in the paper's layout, ours and as published, each followed by what the network gains.

    Parameters
    ----------
    frame, network : as made by and given to :func:`system_frame`
    facts : what our figures were computed on
    settings : those of the tests
    """
    sheets = []
    for source, title in (
        ("ours", "Hidden Markov models and the best network"),
        ("published", "The same as published"),
    ):
        part = frame[frame["source"] == source]
        found = {(row.system, row.metric): row for row in part.itertuples()}
        systems = list(dict.fromkeys(part["system"]))
        if not systems:
            continue
        facts = facts if source == "ours" else (("source", paper.source),)
        best = {metric: _best(found, systems, metric) for metric in PAPER_METRICS}
        heads = tuple(column_title(METRICS[metric]) for metric in PAPER_METRICS)
        rows = [
            (
                _title(system, network),
                tuple(_figure(found[system, m], best[m] == system, digits) for m in PAPER_METRICS),
            )
            for system in systems
        ]
        sheets.append(Sheet(title, heads, tuple(rows), facts=tuple(facts), notes=_notes(source, network)))
        rows = [
            (_title(system, network), tuple(_shown_gain(found[system, metric], settings) for metric in PAPER_METRICS))
            for system in systems
            if found[system, PAPER_METRICS[0]].gain == found[system, PAPER_METRICS[0]].gain
        ]
        note = (
            "Share by which the network's errors are lower, difference of CORR, with paired bootstrap intervals. "
            f"Bold: a paired test over utterances, Holm-corrected, has a p value below {settings.level:g}."
        )
        notes = (note,) if source == "ours" else ("The paper gives no intervals.",)
        sheets.append(
            Sheet(f"{title}: gain over", tuple(METRICS[m].title for m in PAPER_METRICS), tuple(rows), notes=notes)
        )
    return tuple(sheets)


def _title(system: str, network: str) -> str:
    return f"deep BLSTM ({system})" if system == network else row_title(system)


def _best(found, systems, metric: str) -> str:
    sign = 1 if METRICS[metric].best == "low" else -1
    return min(systems, key=lambda system: sign * found[system, metric].value)


def _figure(row, best: bool, digits: int) -> Cell:
    interval = f"[{row.low:.{digits}f}, {row.high:.{digits}f}]" if row.low == row.low else ""
    return Cell(f"{row.value:.{digits}f}", interval, best=best)


def _shown_gain(row, settings: ComparisonSettings) -> Cell:
    form = "{:.1%}".format if METRICS[row.metric].best == "low" else "{:.3f}".format
    interval = f"[{form(row.gain_low)}, {form(row.gain_high)}]" if row.gain_low == row.gain_low else ""
    return Cell(form(row.gain), interval, best=bool(row.p_holm < settings.level))


def _notes(source: str, network: str) -> tuple[str, ...]:
    if source == "published":
        return ()
    return (f"{network} is the network with the lowest error on the validation utterances; intervals are percentile "
            "bootstrap intervals over test utterances.",)  # fmt: skip
