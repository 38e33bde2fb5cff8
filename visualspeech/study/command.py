"""The commands ``visualspeech study serve``, ``simulate`` and ``evaluate``."""

import argparse
import sys
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.jobs import log

LOOPBACK, PORT = "127.0.0.1", 8765


def add_study(commands) -> None:
    """Add ``study`` to the commands of a parser (``add_subparsers``)."""
    study = commands.add_parser("study", help="run, rehearse and evaluate a viewing test", description="Viewing tests.")
    inner = study.add_subparsers(title="commands", required=True, metavar="COMMAND")
    serve = _command(inner, "serve", _serve, "show a study in the browser and store the answers")
    serve.add_argument("--port", type=int, default=PORT, help="port; 0 takes a free one (default: %(default)s)")
    serve.add_argument(
        "--host", default=LOOPBACK,
        help="address to listen at (default: %(default)s, this computer alone; 0.0.0.0 for all networks)",
    )  # fmt: skip
    serve.add_argument(
        "--rehearse", action="store_true",
        help="mark the answers as simulated and keep them apart from those of people; videos need not be watched",
    )  # fmt: skip
    simulate = _command(inner, "simulate", _simulate, "let simulated participants answer through the web interface")
    simulate.add_argument("--participants", type=int, default=20, metavar="N", help="number (default: %(default)s)")
    simulate.add_argument(
        "--preference", action="append", default=[], metavar="CONDITION=SHARE",
        help="share of the answers for a condition, or for `none`; give it once for each (default: equal shares)",
    )  # fmt: skip
    simulate.add_argument(
        "--rating", action="append", default=[], metavar="CONDITION=MEAN",
        help="mean rating of a condition; give it once for each (default: spread over the scale)",
    )  # fmt: skip
    simulate.add_argument("--careless", type=int, default=0, metavar="N", help="of them, how many fail attention items")
    simulate.add_argument("--quitting", type=int, default=0, metavar="N", help="of them, how many stop half-way")
    simulate.add_argument("--seed", type=int, default=1, help="of the answers (default: %(default)s)")
    simulate.add_argument("--at-once", type=int, default=10, metavar="N", help="number at once (default: %(default)s)")
    simulate.add_argument("--replace", action="store_true", help="delete the answers of earlier simulations first")
    evaluate = _command(inner, "evaluate", _evaluate, "write tables and figures of the answers")
    evaluate.add_argument(
        "--simulated", action="store_true", help="evaluate the simulated answers, not those of people"
    )
    evaluate.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER",
        help="folder to write (default: `evaluation`, or `evaluation.simulated`, in DIR)",
    )  # fmt: skip
    evaluate.add_argument(
        "--max-failed-attention", type=int, default=0, metavar="N",
        help="attention items that a participant may fail and still be counted (default: %(default)s)",
    )  # fmt: skip


def _command(commands, name: str, run, text: str) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the study, with study.json")
    parser.add_argument("--debug", action="store_true", help=argparse.SUPPRESS)
    parser.set_defaults(run=run, quiet=False, stopped=_say_stopped)
    return parser


def _say_stopped() -> None:
    print("visualspeech: stopped.", file=sys.stderr, flush=True)


def _serve(given: argparse.Namespace) -> None:
    from visualspeech.study.server import Server

    _check_port(given.port)
    server = Server(given.folder, given.host, given.port, simulated=given.rehearse)

    def stopped() -> None:
        server.store.close()
        print(f"visualspeech: stopped; the answers are in {server.store.path}.", file=sys.stderr, flush=True)

    given.stopped = stopped
    study = server.study
    print(f"Open {server.address} in a browser. The study {study.name} is served until Ctrl+C.", flush=True)
    if given.rehearse:
        print("Rehearsal: answers are marked as simulated and kept apart from those of people.", flush=True)
    elif given.host not in (LOOPBACK, "localhost", "::1"):
        print("Everyone who reaches this address can take part, and the connection is not encrypted.", flush=True)
    server.run()


def _simulate(given: argparse.Namespace) -> None:
    from visualspeech.study.simulation import Behaviour, simulate, stated

    for name, lowest in (("participants", 1), ("careless", 0), ("quitting", 0), ("at_once", 1), ("seed", 0)):
        if not lowest <= getattr(given, name) <= 10_000:
            raise SettingError(f"--{name.replace('_', '-')} {getattr(given, name)}: give {lowest} to 10000.")
    if given.careless + given.quitting > given.participants:
        raise SettingError("--careless and --quitting together are more than --participants.")
    behaviour = Behaviour(
        stated(given.preference, "--preference"), stated(given.rating, "--rating"), given.careless, given.quitting
    )
    done = simulate(given.folder, given.participants, behaviour, given.seed, given.at_once, given.replace)
    log.info("%d simulated participants gave %d answers, stored in %s", given.participants, done.answers, done.path)


def _evaluate(given: argparse.Namespace) -> None:
    from visualspeech.study.evaluation import PAGE, check_folder, default_folder, evaluate, summary, write_evaluation
    from visualspeech.study.evaluation_settings import EvaluationSettings

    if not 0 <= given.max_failed_attention <= 1000:
        raise SettingError(f"--max-failed-attention {given.max_failed_attention}: give 0 to 1000.")
    output = given.output or default_folder(given.folder, given.simulated)
    check_folder(output)
    settings = EvaluationSettings(max_failed_attention=given.max_failed_attention)
    evaluation = evaluate(given.folder, given.simulated, settings)
    write_evaluation(output, evaluation)
    print(summary(evaluation), flush=True)
    log.info("all tables and figures: %s", output / PAGE)


def _check_port(port: int) -> None:
    if not 0 <= port <= 65535:
        raise SettingError(f"--port {port}: give a number from 1 to 65535, or 0 for a free one.")
