"""Serving a study: the checks before it, the socket, and its end."""

import errno
import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path

from visualspeech.errors import SettingError, StorageError
from visualspeech.study.records import MEDIA, Study, read_study
from visualspeech.study.store import AnswerStore


def check_installed() -> None:
    """Raises :class:`SettingError` where the packages of the extra ``study`` are missing."""
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
    except ImportError as error:
        raise SettingError(
            f"`study` needs the package {error.name}. Install the extra with `pip install -c constraints.txt -e "
            "'.[study]'`."
        ) from error


def checked_study(folder: str | Path) -> Study:
    """The study in a folder, all of whose stimuli are there.

    Raises
    ------
    StorageError
        The folder holds no study, or a stimulus is missing.
    """
    study = read_study(folder)
    names = [file for item in study.items for file in item.stimuli]
    names += [study.sound_check.stimulus] if study.sound_check else []
    missing = [name for name in names if not Path(folder, MEDIA, name).is_file()]
    if missing:
        raise StorageError(
            f"{len(missing)} of the {len(names)} videos of the study are missing, the first of them is "
            f"{Path(folder, MEDIA, missing[0])}. Copy the whole folder again, or delete its study.json and make the "
            "study again with `snakemake --cores 2 study`."
        )
    return study


def listening(host: str, port: int) -> socket.socket:
    """A socket that listens; connections wait until the server is ready.

    Raises
    ------
    SettingError
        The port is taken or not allowed, or the host is unknown.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        opened = socket.socket(family, kind, protocol)
    except (OSError, UnicodeError) as error:
        raise SettingError(f"--host {host}: no such address; give one of this computer, such as 127.0.0.1.") from error
    try:
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind(address)
        opened.listen(2048)
    except OSError as error:
        opened.close()
        if error.errno == errno.EADDRINUSE:
            raise SettingError(
                f"--port {port} is in use, perhaps by another study. Stop that server, or give another port."
            ) from error
        raise SettingError(
            f"cannot listen at {host}, port {port}: {os.strerror(error.errno or 0)}. Give another --host or --port."
        ) from error
    return opened


def address_of(opened: socket.socket) -> str:
    """The address to open in a browser; of all interfaces, the name of this computer."""
    host, port = opened.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = socket.gethostname()
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


class Server:
    """A study that is being served.

    Parameters
    ----------
    folder : of the study
    host, port : where it listens; port 0 takes a free one
    simulated : whether answers go to the database of simulated participants

    Raises
    ------
    SettingError, StorageError, DataError
        It cannot be served.
    """

    def __init__(self, folder: str | Path, host: str = "127.0.0.1", port: int = 0, simulated: bool = False) -> None:
        check_installed()
        import uvicorn

        from visualspeech.study.application import Application

        self.study = checked_study(folder)
        self._socket = listening(host, port)
        self.address = address_of(self._socket)
        try:
            self.store = AnswerStore(folder, self.study, simulated)
        except BaseException:
            self._socket.close()
            raise
        config = uvicorn.Config(
            Application(folder, self.study, self.store).asgi,
            http="h11", ws="none", loop="asyncio", lifespan="off", log_config=None, access_log=False,
            server_header=False, proxy_headers=False, timeout_keep_alive=30,
        )  # fmt: skip
        self._server = uvicorn.Server(config)

    def run(self) -> None:
        """Serve until :meth:`stop` or the end of the process."""
        try:
            self._server.run(sockets=[self._socket])
        finally:
            self.store.close()

    def stop(self) -> None:
        """Let :meth:`run` return."""
        self._server.should_exit = True

    def in_background(self) -> Callable[[], None]:
        """Serve in a thread; returns what stops it and waits for its end."""
        thread = threading.Thread(target=self.run, daemon=True)
        thread.start()

        def stop() -> None:
            self.stop()
            thread.join(timeout=20)

        return stop
