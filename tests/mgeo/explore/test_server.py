"""The server: answers in JSON, and nothing for whoever has not the address."""

import json
import threading
import time

import pytest

from mgeo.explore.server import Worker

from .conftest import served


def test_it_serves_the_page_and_its_scripts(client):
    for path, kind, part in [
        ("", "text/html", b"explore.js"),
        ("explore.js", "text/javascript", b"class Parallel"),
        ("plotly.js", "text/javascript", b"plotly.js v"),
    ]:
        status, headers, content = client.send("GET", client.root + path)
        assert status == 200
        assert headers["Content-Type"].startswith(kind)
        assert part in content
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert "Access-Control-Allow-Origin" not in headers


@pytest.mark.cases(2)
@pytest.mark.parametrize("method", ["GET", "POST"])
@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "example.com"},
        {"Host": "127.0.0.1"},
        {"Host": None},
        {"Origin": "https://example.com"},
        {"Origin": "null"},
    ],
)
def test_other_hosts_and_origins_are_refused(client, method, headers):
    path = client.root + ("" if method == "GET" else "api/front")
    sent = {"Content_Type": "application/json", "Content_Length": "2", **headers}
    status, _, content = client.send(method, path, b"{}", **sent)
    assert status == 403
    assert b"rows" not in content


def test_own_origins_are_taken(client):
    for host in client.server.hosts:
        status, found = client.ask("front", Host=host, Origin=f"http://{host}")
        assert status == 200
        assert found["rows"]


def test_without_the_token_there_is_nothing(client):
    token = client.server.token
    assert len(token) >= 32
    another = token[:-1] + ("y" if token.endswith("x") else "x")
    for path in (
        "/",
        "",
        "/favicon.ico",
        f"/{token}",
        f"/{another}/",
        "/api/front",
        "/%C3%A9/",
    ):
        assert client.send("GET", path)[0] == 403
    content = {"Content_Type": "application/json", "Content_Length": "2"}
    assert client.send("POST", "/api/front", b"{}", **content)[0] == 403


def test_each_server_has_its_own_token(client, explorer):
    with served(explorer) as other:
        assert other.server.token != client.server.token
        assert other.send("GET", client.root)[0] == 403


def test_it_listens_to_this_machine_alone(client):
    assert client.server.server_address[0] == "127.0.0.1"


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("name", "body", "status", "message"),
    [
        ("glance", {"design": [0.02, 5.0]}, 400, "design[1] = 5: expected 0.2 to 1 for length [m]"),
        ("glance", {"design": [0.02]}, 400, "design of 1 numbers"),
        ("glance", {"design": ["0.02", 0.5]}, 400, "design[0] = '0.02'"),
        ("glance", {"design": [0.02, 0.5], "other": 1}, 400, "other is unknown"),
        ("glance", {}, 400, "design is missing"),
        ("glance", [], 400, "design is missing"),
        ("glance", b'{"design": [NaN, 0.5]}', 400, "NaN is no finite number"),
        ("glance", b"{", 400, ""),
        ("glance", b"\xff", 400, ""),
        ("limits", {"rows": [999999]}, 400, "expected 0 to"),
        ("limits", {"rows": [-1]}, 400, "expected 0 to"),
        ("save", {"design": [0.02, 0.5], "name": "../a.json"}, 400, "name = '../a.json'"),
        ("nothing", {}, 404, "expected front, glance"),
    ],
)
def test_what_cannot_be_answered_says_why(client, name, body, status, message):
    found = client.ask(name, body)
    assert found[0] == status
    assert message in found[1]["error"]
    assert "\n" not in found[1]["error"]


def test_only_json_of_some_size_is_read(client):
    assert client.ask("front", Content_Type="text/plain")[0] == 415
    assert client.ask("front", Content_Length=None)[0] == 411
    assert client.ask("front", Content_Length="-1")[0] == 411
    assert client.ask("front", Content_Length=str(10**9))[0] == 413
    assert client.send("POST", client.root, b"{}", Content_Length="2")[0] == 404
    assert client.send("GET", f"{client.root}../../etc/passwd")[0] == 404
    assert client.send("GET", f"{client.root}api/front")[0] == 404


def test_saving_twice_asks_first(client, folder):
    asked = {"design": [0.02, 0.5], "name": "plan.json"}
    assert client.ask("save", asked) == (200, {"file": str(folder / "plan.json")})
    status, found = client.ask("save", asked)
    assert status == 409
    assert "there already" in found["error"]
    assert client.ask("save", {**asked, "overwrite": True})[0] == 200


def test_a_bug_of_a_problem_ends_the_request_alone(client, monkeypatch):
    from stand_in import Cantilever

    monkeypatch.setattr(Cantilever, "_evaluate", lambda *given, **more: 1 / 0)
    status, found = client.ask("glance", {"design": [0.0211, 0.5]})
    assert status in (400, 500)
    assert "ZeroDivisionError" in found["error"]
    assert client.send("GET", client.root)[0] == 200


def test_many_ask_at_the_same_time_and_each_gets_its_own(client):
    designs = [[0.02 + 0.0005 * i, 0.5] for i in range(16)]
    expected = [client.ask("glance", {"design": x})[1] for x in designs]
    found = [None] * len(designs)

    def ask(i):
        found[i] = client.ask("glance", {"design": designs[i]})[1]

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(len(designs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == expected
    assert len({json.dumps(each) for each in found}) == len(designs)


def test_a_slider_does_not_wait_for_what_takes_seconds(client, monkeypatch):
    from stand_in import CantileverView

    begun, gate, answers, problems = (
        threading.Event(),
        threading.Event(),
        CantileverView.answers,
        [],
    )

    def slow(view):
        problems.append(view.problem)
        begun.set()
        assert gate.wait(30.0)
        return answers(view)

    monkeypatch.setattr(CantileverView, "answers", slow)
    design, found = {"design": [0.0211, 0.5]}, []
    asked = threading.Thread(target=lambda: found.append(client.ask("answer", design)))
    asked.start()
    assert begun.wait(30.0)
    assert client.ask("glance", design)[0] == 200
    assert not found
    gate.set()
    asked.join()
    assert found[0][0] == 200
    assert problems[0] is not client.server.explorer.problem  # which is one for one thread


def test_the_worker_takes_the_most_urgent_first_one_at_a_time():
    worker, done, running = Worker(), [], []

    def work(name):
        running.append(name)
        assert len(running) == 1
        time.sleep(0.02)
        running.remove(name)
        done.append(name)
        return name

    gate = threading.Event()
    threads = [threading.Thread(target=worker.ask, args=(gate.wait,))]
    threads[0].start()
    for urgency in (3, 1, 2, 0):
        call = (lambda urgency=urgency: work(urgency), urgency)
        threads.append(threading.Thread(target=worker.ask, args=call))
        threads[-1].start()
        time.sleep(0.02)
    gate.set()
    for thread in threads:
        thread.join()
    assert done == [0, 1, 2, 3]
    with pytest.raises(ZeroDivisionError):
        worker.ask(lambda: 1 / 0)
    assert worker.ask(lambda: 7) == 7
