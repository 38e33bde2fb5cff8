"""What a run shows on the terminal: a line per stage, and of jobs that fail their rule, their log and their message.

:class:`Quiet` stands before the handler that Snakemake writes to the terminal with. It reads nothing but the attributes
of log records (``event``, ``jobid``, ...), so this module needs no Snakemake. Its own log file keeps
everything.
"""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

#: Events that are shown in full only where more output is asked for.
HIDDEN = ("workflow_started", "run_info", "job_started", "job_finished", "group_info", "resources_info", "shellcmd")
#: Seconds after which a long stage is mentioned again.
AGAIN = 60.0
#: Attribute of records that are shown as they are.
SHOWN = "visualspeech_shown"
#: Beginnings of Snakemake's messages that stay.
NOTHING = "Nothing to be done"
KEPT = (NOTHING, "Will exit after finishing", "Terminating processes")
#: Beginnings of those that are left out before jobs start, too.
LEFT_OUT = ("Assuming unrestricted shared", "Using shell: ", "host: ")
#: Characters of a job's message in the summary of a run that failed.
MOST = 600
#: Begins the lines of a job's log file that belong to the line above.
_TIME = len("00:00:00 ")


@dataclass(frozen=True)
class Failed:
    """A job that failed.

    Parameters
    ----------
    rule : its rule
    wildcards : what the job was of, such as ``corpus`` and ``model``
    logs : its log files
    """

    rule: str
    wildcards: Mapping[str, str]
    logs: tuple[str, ...] = ()

    def __str__(self) -> str:
        listed = ", ".join(f"{name} {value}" for name, value in self.wildcards.items())
        return f"{self.rule} ({listed})" if listed else self.rule

    def message(self) -> str:
        """The last message in the job's log; empty where there is none."""
        for path in self.logs:
            with suppress(OSError):
                if said := last_message(Path(path).read_text(encoding="utf-8", errors="replace")):
                    return said
        return ""


def last_message(text: str, most: int = MOST) -> str:
    """The last message of a log file, without the time and name before it; of a traceback its last line."""
    lines = [line for line in text.splitlines() if line.strip()]
    begins = [number for number, line in enumerate(lines) if _is_message(line)]
    if not lines:
        return ""
    last = lines[begins[-1] if begins else -1 :]
    if any(line.startswith("Traceback ") for line in last):
        said = last[-1]
    else:
        # After "12:00:00 train_model FBB-128: " follows the message.
        first = last[0][_TIME:].partition(": ")[2] if begins else last[0]
        said = "\n".join([first, *last[1:]])
    return said if len(said) <= most else f"{said[:most]} ..."


def _is_message(line: str) -> bool:
    return line[:_TIME].replace(":", "").strip().isdecimal() and line[2:3] == line[5:6] == ":" and line[8:9] == " "


class Quiet(logging.Handler):
    """Hands on what a user needs to see to another handler.

    Parameters
    ----------
    inner : the handler that writes
    stage_of : rule -> its stage, empty for none; of a rule without one nothing is said
    nothing_to_do : called where everything is up to date
    quiet : False hands on everything, and keeps in mind which jobs fail
    clock : seconds, for tests
    """

    def __init__(
        self,
        inner: logging.Handler,
        stage_of: Callable[[str], str],
        nothing_to_do: Callable[[], None] = lambda: None,
        quiet: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self.inner, self.stage_of, self.quiet, self._clock = inner, stage_of, quiet, clock
        self.nothing_to_do = nothing_to_do
        self.failed: dict[int, Failed] = {}
        self.done = self.total = 0
        self._seen: set[str] = set()
        self._jobs: dict[int, tuple[str, Mapping]] = {}
        self._stage, self._last, self._running = "", clock(), False

    def emit(self, record: logging.LogRecord) -> None:
        event = getattr(record, "event", None)
        event = None if event is None else str(event)
        if getattr(record, SHOWN, False) or not self.quiet:
            self.inner.handle(record)
        if getattr(record, SHOWN, False):
            return
        if event == "run_info":
            self.total = getattr(record, "stats", {}).get("total", 0)
        elif event == "job_info":
            self._begins(record)
        elif event == "progress":
            self.done, self.total = record.done, record.total
            if self.quiet and self._clock() - self._last >= AGAIN:
                self._say_progress()
        elif event in ("job_error", "group_error"):
            self._fails(record)
        elif self.quiet and event not in HIDDEN and not self._is_hidden(record, event):
            self.inner.handle(record)
        if event is None and str(record.msg).startswith(NOTHING):
            self.nothing_to_do()

    def starts(self, logs: Sequence[str] = ()) -> None:
        """Called when jobs are about to start: from now on, Snakemake's remarks about its scheduling are left out.

        Parameters
        ----------
        logs : files that hold every message of the run
        """
        self._running = True
        if self.quiet:
            self.say(" ".join([f"{self.total} jobs.", *(f"All messages: {path}" for path in logs[:1])]))

    def say(self, text: str, level: int = logging.INFO) -> None:
        """Show a line."""
        record = logging.LogRecord("visualspeech", level, "", 0, text, None, None)
        self.inner.handle(record)

    def _begins(self, record: logging.LogRecord) -> None:
        rule = record.rule_name
        self._jobs[record.jobid] = (rule, dict(getattr(record, "wildcards", None) or {}))
        stage = self.stage_of(rule) if self.quiet else ""
        if stage and stage != self._stage:
            self._stage = stage
            if stage not in self._seen:
                self._seen.add(stage)
                self._say_progress()

    def _say_progress(self) -> None:
        self._last = self._clock()
        count = f"{self.done} of {self.total} jobs done" if self.total else ""
        self.say(f"{time.strftime('%H:%M:%S')}  {self._stage:<16} {count}".rstrip())

    def _fails(self, record: logging.LogRecord) -> None:
        infos: Sequence = getattr(record, "job_error_info", None) or [record.__dict__]
        for info in infos:
            number = info["jobid"]
            rule, wildcards = self._jobs.get(number, (info["rule_name"], {}))
            if number not in self.failed:
                self.failed[number] = Failed(rule, wildcards, tuple(map(str, info.get("log") or ())))

    def _is_hidden(self, record: logging.LogRecord, event: str | None) -> bool:
        """Remarks about scheduling, and what Snakemake says of a job whose failure is reported anyway."""
        text = str(record.msg)
        if record.levelno >= logging.ERROR:
            of_a_job = "CalledProcessError" in text or text.startswith("Exiting because a job execution failed")
            return of_a_job or (bool(self.failed) and "At least one job did not complete" in text)
        if record.levelno >= logging.WARNING:
            return False
        return text.startswith(LEFT_OUT) or (self._running and not text.startswith(KEPT))

    def close(self) -> None:
        self.inner.close()
        super().close()

    def flush(self) -> None:
        self.inner.flush()
