"""What protects every page: headers, a bound on what is sent, and no writing from other sites."""

from collections.abc import Awaitable, Callable

#: Bytes of the body of a request; an answer has some hundred.
MAX_BODY = 64 * 1024
#: Nothing is loaded from elsewhere, nothing runs that is no file of the study, and no other page shows it in a frame.
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; media-src 'self'; connect-src 'self'; "
        "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class _TooLarge(Exception):
    pass


class Guards:
    """ASGI middleware: adds headers, answers 413 to a large body without reading it and 403 to posts of other sites."""

    def __init__(self, app) -> None:
        self.app = app

    async def __call__(self, scope, receive: Callable[[], Awaitable], send: Callable) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = {name: value for name, value in scope["headers"]}
        started = False

        async def guarded(message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                given = {name.lower() for name, _ in message["headers"]}
                extra = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
                message["headers"] = [*message["headers"], *((n, v) for n, v in extra if n.lower() not in given)]
            await send(message)

        if scope["method"] not in ("GET", "HEAD") and headers.get(b"sec-fetch-site") == b"cross-site":
            await _say(guarded, 403, "This was sent from another site.")
            return
        length = headers.get(b"content-length", b"0")
        if not length.isdigit() or int(length[:20]) > MAX_BODY:
            await _say(guarded, 413, "This is too large.")
            return
        read = 0

        async def bounded():
            nonlocal read
            message = await receive()
            read += len(message.get("body", b""))
            if read > MAX_BODY:
                raise _TooLarge
            return message

        try:
            await self.app(scope, bounded, guarded)
        except _TooLarge:
            if not started:
                await _say(guarded, 413, "This is too large.")


async def _say(send: Callable, status: int, text: str) -> None:
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": text.encode()})
