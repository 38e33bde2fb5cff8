"""The web application over real connections: what it serves, what it stores, and what it refuses."""

import json
import shutil
import socket
import time

import pytest

from tests.unit.study import studies
from tests.unit.study.visitors import FORM, Client, serving
from visualspeech.study import store as store_module
from visualspeech.study.layouts import RATING
from visualspeech.study.records import read_answers, read_participants, read_study

RIGHT = {"preference": "right"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return studies.make(tmp_path_factory.mktemp("studies") / "study", seconds=0.4)


@pytest.fixture
def folder(made, tmp_path):
    return shutil.copytree(made, tmp_path / "study")


@pytest.fixture
def client(folder):
    with serving(folder) as server:
        yield Client(server.address)


def watched(client, code):
    """The current page, whose video has had the time to be played."""
    page = client.page(code)
    time.sleep(0.45)
    return page


def test_a_whole_participation_is_stored(client, folder):
    code = client.begin(word="")
    assert client.page(code).kind == "sound"
    status, _, text = client.form(f"/p/{code}/sound", word="river")
    assert status == 422 and b"another word" in text and client.page(code).kind == "sound"
    assert client.form(f"/p/{code}/sound", word="table")[0] == 303
    study, shown = read_study(folder), []
    while (page := watched(client, code)).kind == "item":
        assert page.stimulus in study.item(page.item).stimuli
        shown.append((page.item, study.item(page.item).stimuli.index(page.stimulus)))
        assert client.answer(code, page.item, RIGHT) == (200, {"stored": True, "next": f"/p/{code}"})
    assert page.kind == "done" and page.done == page.total == 5
    answers = read_answers(folder)
    assert [(one.item, one.mirrored) for one in answers] == shown and [one.position for one in answers] == [*range(5)]
    (participant,) = read_participants(folder)
    assert participant.code == code and participant.finished and not participant.simulated
    stored = b"".join(path.read_bytes() for path in folder.glob("answers.sqlite*"))
    assert b"127.0.0.1" not in stored and b"python" not in stored.lower()


def test_a_rating_is_asked_with_every_question(tmp_path):
    folder = studies.make(tmp_path / "study", RATING, sound=False, seconds=0.2)
    with serving(folder) as server:
        client = Client(server.address)
        code = client.begin(word="")
        page, good = watched(client, code), {"face": 1, "eyebrows": 10, "lips": 5}
        wrong = [
            {**good, "lips": value} for value in (0, 11, 5.5, "5", True, None, [5], {"a": 1}, 10**30, float("nan"))
        ]
        wrong += [{"face": 1}, {**good, "more": 1}, {}]
        for values in wrong:
            assert client.answer(code, page.item, values)[0] == 422, values
        assert read_answers(folder) == ()
        assert client.answer(code, page.item, good)[0] == 200
    assert {one.question: one.value for one in read_answers(folder)} == good


def test_questions_are_answered_after_the_video_alone(client, folder):
    code = client.begin()
    page = client.page(code)
    status, said = client.answer(code, page.item, RIGHT)
    assert (status, said["message"]) == (422, "Please play the video to its end first.")
    time.sleep(0.45)
    assert client.answer(code, page.item, RIGHT, played=False)[0] == 422
    assert client.answer(code, page.item, RIGHT)[0] == 200 and len(read_answers(folder)) == 1


def test_items_are_answered_in_their_order_and_once(client, folder):
    code = client.begin()
    page = watched(client, code)
    later = next(one.id for one in read_study(folder).items if one.id != page.item)
    assert client.answer(code, later, RIGHT)[0] == 409
    assert client.answer(code, page.item, RIGHT)[0] == 200
    # The answer was lost on its way back, and the browser sends it again.
    assert client.answer(code, page.item, RIGHT)[0] == 200
    # Another tab shows the same video still.
    status, said = client.answer(code, page.item, {"preference": "left"})
    assert status == 409 and "the first answer counts" in said["message"]
    (answer,) = read_answers(folder)
    assert answer.value == "right" and client.page(code).item != page.item


def test_a_lost_page_is_continued_where_it_was(folder):
    with serving(folder) as server:
        client = Client(server.address)
        code = client.begin()
        page = watched(client, code)
        assert client.answer(code, page.item, RIGHT)[0] == 200
        before = client.page(code)
    with serving(folder) as server:  # the server was started again
        after = Client(server.address).page(code)
    assert (after.item, after.stimulus, after.done) == (before.item, before.stimulus, 1)


def test_consent_is_needed_and_its_form_may_be_sent_twice(client, folder):
    assert client.form("/participants", ticket="0" * 32)[0] == 422
    assert client.form("/participants", ticket="x", consent="yes")[0] == 422
    assert client.request("POST", "/participants", b"\xff\xfe", FORM)[0] == 422
    places = {client.form("/participants", ticket="a" * 32, consent="yes")[1]["location"] for _ in range(3)}
    assert len(places) == len(read_participants(folder)) == 1


@pytest.mark.parametrize("code", ["aaaaaaaaaaaa", "1", "%27%20OR%201=1", "..", "a" * 5000, "%00", "AAAAAAAAAAAA"])
def test_unknown_codes_are_not_found(client, code):
    assert client.get(f"/p/{code}")[0] in (404, 400)
    assert client.request("POST", f"/p/{code}/answers", b'{"item": "i0", "played": true, "answers": {}}')[0] in (
        404,
        422,
    )
    assert client.form(f"/p/{code}/sound", word="table")[0] in (404, 400)


def test_nothing_but_stimuli_and_pages_can_be_read(client, folder):
    key = (folder / "key.json").read_bytes()[:200]
    (folder / "media" / "secret.mp4").write_bytes(key)
    stimulus = read_study(folder).items[0].stimuli[0]
    (folder / "media" / stimulus).unlink()
    (folder / "media" / stimulus).symlink_to(folder / "key.json")
    paths = [
        "/key.json", "/study.json", "/answers.sqlite", "/media/", "/media/key.json", "/media/../key.json",
        "/media/%2e%2e/key.json", "/media/..%2fkey.json", "/media/%2e%2e%2fkey.json", "/media/..%5ckey.json",
        "/static/../application.py", "/static/%2e%2e%2fapplication.py", "/static/item.html", "/media//etc/passwd",
        "//etc/passwd", "/../../../../etc/passwd", "/media/secret.mp4", f"/media/{stimulus}", f"/media/{stimulus}/",
        f"/media/{stimulus}%00.mp4", "/docs", "/openapi.json",
    ]  # fmt: skip
    for path in paths:
        status, _, text = client.get(path)
        assert status in (400, 404) and key[:40] not in text and b"root:" not in text, path


def test_a_video_can_be_read_in_parts(client, folder):
    name = read_study(folder).items[0].stimuli[0]
    whole = (folder / "media" / name).read_bytes()
    status, headers, body = client.get(f"/media/{name}")
    assert status == 200 and body == whole and headers["content-type"] == "video/mp4"
    status, headers, body = client.get(f"/media/{name}", Range="bytes=100-199")
    assert status == 206 and body == whole[100:200]
    assert headers["content-range"] == f"bytes 100-199/{len(whole)}"
    assert client.get(f"/media/{name}", Range="bytes=-10")[2] == whole[-10:]
    assert client.get(f"/media/{name}", Range=f"bytes={len(whole)}-")[0] == 416
    assert client.get(f"/media/{name}", Range="bytes=x-y")[0] in (200, 400)
    assert client.request("HEAD", f"/media/{name}")[2] == b""


def test_a_large_body_is_refused_without_being_read(client):
    begun = time.monotonic()
    raw = socket.create_connection((client.parts.hostname, client.parts.port), timeout=10)
    raw.sendall(b"POST /p/aaaaaaaaaaaa/answers HTTP/1.1\r\nHost: x\r\nContent-Length: 104857600\r\n\r\n")
    assert raw.recv(100).startswith(b"HTTP/1.1 413")
    raw.close()
    # Without a stated length it is cut off after the first parts.
    raw = socket.create_connection((client.parts.hostname, client.parts.port), timeout=10)
    raw.sendall(b"POST /participants HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n")
    sent = 0
    try:
        for _ in range(1600):
            raw.sendall(b"10000\r\n" + b"x" * 65536 + b"\r\n")
            sent += 65536
    except OSError:
        pass
    assert sent < 50_000_000 and time.monotonic() - begun < 10
    raw.close()
    for length in ("-1", "x", "99999999999999999999999"):
        raw = socket.create_connection((client.parts.hostname, client.parts.port), timeout=10)
        raw.sendall(f"POST /participants HTTP/1.1\r\nHost: x\r\nContent-Length: {length}\r\n\r\n".encode())
        assert raw.recv(100)[9:12] in (b"400", b"413")
        raw.close()
    assert client.get("/")[0] == 200


NO_ANSWERS = (
    b"", b"{", b"[]", b"3", b"null", b'{"item": 1}', b"[" * 20_000, b"\xff",
    b'{"item": [], "played": true, "answers": {}}', b'{"item": "i0", "played": true, "answers": 5}',
    b'{"item": "\\ud800", "played": true, "answers": {"\\ud800": "\\ud800"}}',
)  # fmt: skip


@pytest.mark.parametrize("body", NO_ANSWERS)
def test_what_is_no_answer_is_refused(client, folder, body):
    code = client.begin()
    status, headers, text = client.request("POST", f"/p/{code}/answers", body)
    assert status in (404, 422) and json.loads(text)["stored"] is False
    assert read_answers(folder) == ()


def test_every_page_is_guarded(client):
    for path in ("/", "/p/nobody", "/nothing", "/static/study.js"):
        headers = client.get(path)[1]
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"] and "set-cookie" not in headers
        assert headers["x-content-type-options"] == "nosniff" and "server" not in headers
    text = client.get("/")[2].decode()
    assert "http://" not in text and "https://" not in text
    assert client.request("POST", "/participants", b"consent=yes", {**FORM, "Sec-Fetch-Site": "cross-site"})[0] == 403
    assert client.request("DELETE", "/")[0] == 405


def test_texts_of_a_study_are_no_markup(folder):
    about = json.loads((folder / "study.json").read_text())
    about["title"] = about["consent"] = "<script>alert(1)</script>"
    (folder / "study.json").write_text(json.dumps(about))
    with serving(folder) as server:
        assert b"<script>alert" not in Client(server.address).get("/")[2]


def test_a_full_disk_is_told_and_nothing_is_claimed(folder):
    with serving(folder) as server:
        client = Client(server.address)
        code = client.begin()
        page = watched(client, code)
        database = server.store._database
        (pages,) = database.execute("PRAGMA page_count").fetchone()
        database.execute(f"PRAGMA max_page_count = {pages + 1}")  # as a disk that is nearly full
        told = []
        while not told or told[-1] == 303:
            status, _, text = client.form("/participants", ticket=f"{len(told):032x}", consent="yes")
            told.append(status)
        assert told[-1] == 507 and b"could not be stored" in text
        assert len(read_participants(folder)) == told.count(303) + 1
        stored = [client.answer(code, page.item, RIGHT)[0]]
        assert len(read_answers(folder)) == stored.count(200)
        database.execute("PRAGMA max_page_count = 100000")
        assert client.answer(code, page.item, RIGHT)[0] == 200 and len(read_answers(folder)) == 1


def test_simulated_participants_need_not_watch_and_say_so(folder):
    with serving(folder, simulated=True) as server:
        client = Client(server.address)
        code = client.begin()
        assert b"Rehearsal" in client.get("/")[2]
        assert client.answer(code, client.page(code).item, RIGHT)[0] == 200
    assert read_answers(folder) == () and len(read_answers(folder, simulated=True)) == 1
    assert read_participants(folder, simulated=True)[0].simulated


def test_an_unexpected_error_tells_nothing(client, monkeypatch):
    code = client.begin()
    monkeypatch.setattr(store_module.AnswerStore, "step", lambda *_: 1 / 0)
    status, _, text = client.get(f"/p/{code}")
    assert status == 500 and b"ZeroDivision" not in text and b"server failed" in text
