# What a run shows on the terminal, and its last lines.
import sys

from visualspeech.evaluation.summary import failed, finished, speak_commands, study_commands
from visualspeech.jobs import settle_quiet
from visualspeech.progress import SHOWN, Quiet

#: Snakemake's name of the handler that writes to the terminal.
TERMINAL = "DefaultStreamHandler"


def is_quiet():
    """Whether the terminal shows a line per stage: unless the command line asks for more, or for less."""
    asked = workflow.output_settings
    return not (asked.verbose or asked.printshellcmds or asked.debug_dag or asked.quiet)


def is_own_run():
    """Whether this process runs jobs of this workflow by itself: no dry run, no job's own process, no module of another
    workflow."""
    own = Path(workflow.current_basedir).parents[1] / "Snakefile"
    main = Path(workflow.main_snakefile).resolve() == own.resolve()
    return main and workflow.is_main_process and not workflow.output_settings.dryrun


def stage_of(rule):
    """Stage of a rule, by the file that it stands in; targets have none."""
    stage = Path(workflow.get_rule(rule).snakefile).stem
    return "" if stage == "Snakefile" else stage.replace("_", " ")


def show_progress():
    """Put the messages of this workflow in place of Snakemake's; returns what keeps count of the jobs, or None."""
    found = [one for one in logger.handlers if one.name == TERMINAL]
    if not found or not is_own_run():
        return None
    quiet = Quiet(found[0], stage_of, show_end, is_quiet())
    settle_quiet(quiet.quiet)
    logger.removeHandler(found[0])
    logger.addHandler(quiet)
    return quiet


def show(lines):
    for line in lines:
        logger.info(line, extra={SHOWN: True})


def summarised(name):
    """What the last lines of a run say of a corpus."""
    systems = []
    for one in (OfSystem(name, system) for system in PLAN.systems(name)):
        rows = rows_of(one.system)
        files = {row.name: filled("<model>/validation.tsv", one, model=row.name)[0] for row in rows}
        systems.append({"name": one.system, "rows": [row.plain() for row in rows], "validation": files})
    one = OfCorpus(name)
    codings = filled("<coding>/findings.tsv", one, coding=PLAN.codings(name))
    return {
        "name": name,
        "report": filled("<corpus>/report.html", one)[0],
        "findings": [*filled("<corpus>/findings.tsv", one), *codings],
        "utterances": len(PLAN.corpora[name].split),
        "systems": systems,
    }


class OfCorpus:
    """Wildcards of a corpus, for the functions that take a job's."""

    def __init__(self, corpus):
        self.corpus = corpus

    def items(self):
        return (("corpus", self.corpus),)


def what_next():
    """What to type after a run: the commands that let the head speak, or show the viewing tests that were asked for."""
    if "study" in workflow.dag_settings.targets:
        made = [filled("<study>/study.json", OfStudy(*one))[0] for one in PLAN.studies]
        return study_commands([str(Path(one).parent) for one in made if Path(one).is_file()], sys.argv)
    for corpus, system, model in SPEAKERS:
        if model:
            folder = filled("<system>/speakers/{model}", OfSystem(corpus, system), model=model)[0]
            made = Path(folder, "speaker.json").is_file()
            return speak_commands(folder, made, sys.argv, workflow.dag_settings.targets)
    return []


def show_end():
    """The last lines of a run that has ended well, or had nothing to do."""
    try:
        show(finished(list(map(summarised, PLAN.corpora)), what_next()))
    except (VisualSpeechError, OSError) as error:
        logger.warning(f"the results cannot be summarised: {error}")


def show_failure():
    """The last lines of a run that has failed."""
    if PROGRESS:
        show(failed(list(PROGRESS.failed.values()), PROGRESS.done, PROGRESS.total))


PROGRESS = show_progress()
