"""A plain HTTP client for the tests of the web application, and the server under test."""

import http.client
import json
from contextlib import contextmanager
from urllib.parse import urlencode, urlsplit

from visualspeech.study.server import Server
from visualspeech.study.simulation import Page

FORM = {"Content-Type": "application/x-www-form-urlencoded"}


@contextmanager
def serving(folder, **options):
    """The server of a study at a free port."""
    server = Server(folder, port=0, **options)
    stop = server.in_background()
    try:
        yield server
    finally:
        stop()


class Client:
    """Requests to a server; the path is sent as it is given."""

    def __init__(self, address):
        self.parts = urlsplit(address)

    def request(self, method, path, body=None, headers=None):
        """Status, headers and text of an answer."""
        connection = http.client.HTTPConnection(self.parts.hostname, self.parts.port, timeout=30)
        try:
            connection.request(method, path, body, headers or {})
            reply = connection.getresponse()
            return reply.status, {name.lower(): value for name, value in reply.getheaders()}, reply.read()
        finally:
            connection.close()

    def get(self, path, **headers):
        return self.request("GET", path, headers=headers)

    def form(self, path, **values):
        return self.request("POST", path, urlencode(values).encode(), FORM)

    def answer(self, code, item, values, played=True):
        body = json.dumps({"item": item, "played": played, "answers": values}).encode()
        status, _, text = self.request("POST", f"/p/{code}/answers", body)
        return status, json.loads(text)

    def begin(self, word="table"):
        """A new participant who has passed the sound check; returns the code."""
        ticket = Page(self.get("/")[2].decode()).ticket
        status, headers, _ = self.form("/participants", ticket=ticket, consent="yes")
        assert status == 303
        code = headers["location"].rpartition("/")[2]
        if word:
            assert self.form(f"/p/{code}/sound", word=word)[0] == 303
        return code

    def page(self, code):
        """The page at which a participant is."""
        status, _, text = self.get(f"/p/{code}")
        assert status == 200
        return Page(text.decode())
