"""The web application of a study: consent, sound check, practice, items and their questions, thanks.

All that is served is made from ``study.json``, the database, and files that the study names. Pages load nothing from
elsewhere, set no cookies, and neither addresses nor names of browsers are kept.
"""

import json
import os
import re
import secrets
import stat
from pathlib import Path
from urllib.parse import parse_qsl

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route

from visualspeech.study.guards import Guards
from visualspeech.study.layouts import ATTENTION, PRACTICE
from visualspeech.study.records import MEDIA, Study
from visualspeech.study.store import AnswerStore, NotStored, Refused, Step

PAGES = Path(__file__).resolve().parent / "pages"
STATIC = {"study.css": "text/css", "study.js": "text/javascript"}
TYPES = {".mp4": "video/mp4", ".wav": "audio/wav"}
CODE = re.compile(r"[0-9a-z]{1,40}")
TICKET = re.compile(r"[0-9a-f]{32}")
FULL = (
    "Your answer could not be stored: the disk of the computer that runs this study may be full. Please tell the "
    "person who runs it, leave this page open and try again later."
)
UNKNOWN = "There is no such participant. Check the address, or begin on the first page."


class Message(Exception):
    """A page with a message, or the same as JSON; ``status`` is that of HTTP."""

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status, self.text = status, text


class Application:
    """Answers the requests of participants; ``asgi`` is what a server runs.

    Parameters
    ----------
    folder : of the study
    store : where its answers are kept
    """

    def __init__(self, folder: str | Path, study: Study, store: AnswerStore) -> None:
        self.study, self.store, self.media = study, store, Path(folder, MEDIA)
        self.files = {file for item in study.items for file in item.stimuli}
        self.files |= {study.sound_check.stimulus} if study.sound_check else set()
        environment = Environment(
            loader=FileSystemLoader(PAGES), autoescape=select_autoescape(), undefined=StrictUndefined, trim_blocks=True
        )
        environment.globals.update(study=study, simulated=store.simulated)
        self._templates = {
            name: environment.get_template(f"{name}.html") for name in ("consent", "sound", "item", "done", "message")
        }
        application = Starlette(
            routes=[
                Route("/", self.consent),
                Route("/participants", self.begin, methods=["POST"]),
                Route("/p/{code}", self.participation),
                Route("/p/{code}/sound", self.sound, methods=["POST"]),
                Route("/p/{code}/answers", self.answers, methods=["POST"]),
                Route("/media/{name}", self.medium),
                Route("/static/{name}", self.static),
                Route("/favicon.ico", lambda request: Response(status_code=204)),
            ],
            middleware=[Middleware(Guards)],
            exception_handlers={
                Message: self._message,
                NotStored: self._not_stored,
                HTTPException: self._http,
                Exception: self._failed,
            },
        )
        application.router.redirect_slashes = False
        self.asgi = application

    def consent(self, request: Request) -> Response:
        """The first page."""
        return self._page("consent", ticket=secrets.token_hex(16))

    async def begin(self, request: Request) -> Response:
        """A new participant, who has consented."""
        form = await self._form(request)
        ticket = form.get("ticket", "")
        if form.get("consent") != "yes" or not TICKET.fullmatch(ticket):
            raise Message(422, "You can take part only if you agree. Please go back and tick the box.")
        code = await run_in_threadpool(self.store.start, ticket)
        return RedirectResponse(f"/p/{code}", status_code=303)

    def participation(self, request: Request) -> Response:
        """The step at which a participant is."""
        code = request.path_params["code"]
        step = self._known(code)
        if step.sound:
            return self._page("sound", code=code, again=False, **self._progress(step))
        if step.item is None:
            return self._page("done", code=code, **self._progress(step))
        self.store.open(step)
        return self._page(
            "item",
            code=code,
            item=step.item,
            stimulus=step.item.stimuli[step.mirrored],
            practice=step.item.role == PRACTICE,
            **self._progress(step),
        )

    async def sound(self, request: Request) -> Response:
        """The answer to the sound check: on with the study, or the same page again."""
        code, form = request.path_params["code"], await self._form(request)
        step = await run_in_threadpool(self._known, code)
        if step.sound and form.get("word") != self.study.sound_check.answer:
            return self._page("sound", 422, code=code, again=True, **self._progress(step))
        if step.sound:
            await run_in_threadpool(self.store.pass_sound, code)
        return RedirectResponse(f"/p/{code}", status_code=303)

    async def answers(self, request: Request) -> Response:
        """Answers to one item as JSON: ``{"item": ..., "played": true, "answers": {question: value}}``."""
        code = request.path_params["code"]
        try:
            given = json.loads(await request.body())
            item, played, values = given["item"], given["played"] is True, dict(given["answers"])
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise Message(422, "This is not an answer to a video.") from error
        if not CODE.fullmatch(code):
            raise Message(404, UNKNOWN)
        if not isinstance(item, str) or not all(isinstance(one, str | int) for one in values.values()):
            raise Message(422, "This is not an answer to a video.")
        try:
            await run_in_threadpool(self.store.answer, code, item, values, played)
        except Refused as refused:
            raise Message(refused.status, refused.message) from None
        return JSONResponse({"stored": True, "next": f"/p/{code}"})

    def medium(self, request: Request) -> Response:
        """A stimulus, in whole or in parts."""
        name = request.path_params["name"]
        path = self.media / name
        if name not in self.files or not _is_regular(path):
            raise Message(404, "There is no such video.")
        return FileResponse(path, media_type=TYPES[path.suffix], headers={"Cache-Control": "private, max-age=3600"})

    def static(self, request: Request) -> Response:
        """The style sheet and the script of the pages."""
        name = request.path_params["name"]
        if name not in STATIC:
            raise Message(404, "There is no such page.")
        return FileResponse(PAGES / name, media_type=STATIC[name], headers={"Cache-Control": "no-cache"})

    async def _form(self, request: Request) -> dict[str, str]:
        try:
            return dict(parse_qsl((await request.body()).decode("ascii"), max_num_fields=20))
        except ValueError:
            raise Message(422, "This form could not be read.") from None

    def _known(self, code: str) -> Step:
        step = self.store.step(code) if CODE.fullmatch(code) else None
        if step is None:
            raise Message(404, UNKNOWN)
        return step

    def _progress(self, step: Step) -> dict:
        """What all pages of a participation show: number of the video, without practice, and all of them."""
        practice = len(self.study.of_role(PRACTICE))
        return {
            "done": step.position,
            "total": step.total,
            "number": step.position - practice + 1,
            "videos": step.total - practice,
            "attention": len(self.study.of_role(ATTENTION)),
        }

    def _page(self, name: str, status: int = 200, **values) -> HTMLResponse:
        return HTMLResponse(self._templates[name].render(**values), status)

    def _said(self, request: Request, status: int, text: str) -> Response:
        if request.url.path.endswith("/answers"):
            return JSONResponse({"stored": False, "message": text}, status)
        return self._page("message", status, text=text)

    def _message(self, request: Request, error: Message) -> Response:
        return self._said(request, error.status, error.text)

    def _not_stored(self, request: Request, error: NotStored) -> Response:
        return self._said(request, 507, FULL)

    def _http(self, request: Request, error: HTTPException) -> Response:
        text = {404: "There is no such page.", 405: "This page cannot be used in this way."}
        return self._said(request, error.status_code, text.get(error.status_code, "This request cannot be answered."))

    def _failed(self, request: Request, error: Exception) -> Response:
        return self._said(request, 500, "The server failed; please tell the person who runs the study.")


def _is_regular(path: Path) -> bool:
    """Whether a path is a file itself, and no link to one."""
    try:
        return stat.S_ISREG(os.lstat(path).st_mode)
    except OSError:
        return False
