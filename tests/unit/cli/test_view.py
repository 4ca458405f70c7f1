"""The live page: what moves gives a new motion, what is wrong is said at its line, and nobody else is let in."""

from __future__ import annotations

import http.client
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import numpy as np
import pytest

import freebody as fb
from freebody.cli.view import LARGEST_REQUEST, Server, machine
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.picture.page.browser import chromium
from freebody.picture.page.live import Live, problem
from page_browser import PageBrowser
from page_data import unpacked

TEXT = """name = "swing"
gravity = [0, "-g", 0]
[parameters]
g = 9.81
L = 1
[bodies.bar]
solid = "slender_bar"
mass = 1
length = "L"
axis = "y"
[joints.pin]
type = "hinge"
child = "bar"
to = [0, "L/2", 0]
coordinate = "theta"
[initial]
theta = 0.5
[run]
until = 2
"""


@pytest.fixture
def live() -> Live:
    from freebody.formats.toml.read import case_from_text

    return Live(case_from_text(TEXT), TEXT)


@pytest.fixture
def server(live: Live) -> Iterator[Server]:
    one = Server(live)
    thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    yield one
    one.shutdown()
    one.server_close()
    thread.join(5)


def ask(
    server: Server, method: str, path: str, body: str | None = None, **headers: str
) -> tuple[int, str, dict]:
    host, port = server.server_address[:2]
    connection = http.client.HTTPConnection(host, port, timeout=10)
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, body, given)
    answer = connection.getresponse()
    result = answer.status, answer.read().decode("utf-8"), dict(answer.headers)
    connection.close()
    return result


def post(server: Server, what: str, data: object, **headers: str) -> tuple[int, str, dict]:
    given = {"Origin": origin(server), "Content_Type": "application/json", **headers}
    return ask(server, "POST", f"/{server.token}/{what}", json.dumps(data), **given)


def origin(server: Server) -> str:
    return f"http://127.0.0.1:{server.server_address[1]}"


# --- the machine ---------------------------------------------------------------------------------------------------


def test_a_change_gives_another_motion(live):
    before = live.machine()
    assert [(x["group"], x["name"], x["value"]) for x in before["sliders"]] == [
        ("values", "g", 9.81), ("values", "L", 1.0), ("initial", "theta", 0.5), ("initial", "theta'", 0.0),
    ]  # fmt: skip
    assert "<use" in before["equations"] and 'data-chart="0"' in before["charts"]
    longer = live.motion({"L": 2}, {"theta": 0.3}, 3)
    assert longer["scene"]["size"] == 2 and before["scene"]["size"] == 1
    assert not np.array_equal(longer["scene"]["t"], before["scene"]["t"])


def test_a_start_that_holds_parameters_follows_them():
    live = machine("gyroscope", ())
    first = {x["name"]: x["value"] for x in live.machine()["sliders"]}
    assert first["phi'"] == 300 and first["theta"] == pytest.approx(1.0471975511965976)
    slow = live.motion({"Omega_zeta": 100}, {}, 0.01)["scene"]
    fast = live.motion({"Omega_zeta": 100}, {"phi'": 300}, 0.01)["scene"]
    assert not np.array_equal(slow["bodies"][0]["spin"], fast["bodies"][0]["spin"])


def test_sliders_are_those_that_move_something_and_say_what_they_follow():
    """Two parameters of the gyroscope stand in the start alone, and two in questions about it: those have no slider."""
    live = machine("gyroscope", ())
    sliders = {x["name"]: x for x in live.machine()["sliders"]}
    rest = live._trajectory.states
    assert sliders["theta"]["follows"] == ["theta_0"] and sliders["phi'"]["follows"] == ["Omega_zeta"]
    assert "theta_low" not in sliders and "t_1" not in sliders
    for name, slider in sliders.items():
        assert name in ("theta", "phi'") or slider["follows"] == []
        answer = (
            live.motion({name: 1.01 * slider["value"]}, {}, live.until)
            if slider["group"] == "values"
            else None
        )
        if answer is not None:
            states = live._trajectory.states
            assert states.shape != rest.shape or (states != rest).any(), name
    assert live.motion({"theta_0": 0.5}, {}, 0.01)["start"]["theta"] == 0.5


def test_a_machine_whose_equations_can_not_be_written_moves(live, monkeypatch):
    import freebody.picture.page.live as module

    def refuse(motion, symbols):
        raise ModelError("Expected <few> terms.")

    monkeypatch.setattr(module, "balances", refuse)
    shown = live.machine()
    assert shown["equations"] == "<p>Expected &lt;few&gt; terms.</p>" and shown["scene"]


def test_nonsense_is_refused(live):
    for values, initial, until, message in (
        ({"q": 1}, {}, 1, "q"),
        ({}, {"phi": 1}, 1, "Unknown coordinate or speed 'phi' of 'swing'"),
        ({"L": "1"}, {}, 1, "Expected a finite number for 'L', got '1'"),
        ({"L": float("nan")}, {}, 1, "Expected a finite number for 'L', got nan"),
        ({}, {"theta": True}, 1, "Expected a finite number for 'theta', got True"),
        ({"L": 10**400}, {}, 1, "Expected a finite number for 'L', got 1000"),
        ({}, {}, None, "Expected a finite number for 'until', got None"),
        ({}, {}, -1, "Expected the length of the run between 0 and 1e6 s, got -1 s"),
    ):
        with pytest.raises((ModelError, SimulationError), match=message):
            live.motion(values, initial, until)


def test_a_text_that_is_no_model_leaves_the_machine(live):
    with pytest.raises(FormatError) as caught:
        live.change(TEXT.replace('solid = "slender_bar"', 'solid = "slender_ba"'))
    assert (
        problem(caught.value)["line"] == 7 and "did you mean 'slender_bar'" in problem(caught.value)["error"]
    )
    assert live.text == TEXT and live.motion({}, {}, 1)
    changed = live.change(TEXT.replace('"swing"', '"other"').replace("L = 1", "L = 3"))
    assert changed["name"] == "other" and changed["scene"]["size"] == 3


# --- the server ----------------------------------------------------------------------------------------------------


def test_the_page_answers_under_its_token(server):
    code, text, headers = ask(server, "GET", f"/{server.token}/")
    assert code == 200 and "connect-src" in text and "<h1" in text
    assert headers["X-Content-Type-Options"] == "nosniff" and headers["Cache-Control"] == "no-store"
    assert "Access-Control-Allow-Origin" not in headers
    code, text, _ = post(server, "motion", {"values": {"L": 2}, "initial": {}, "until": 1})
    assert code == 200 and unpacked(text)["scene"]["size"] == 2
    code, text, _ = post(server, "model", {"text": "name = ?"})
    assert code == 200 and unpacked(text)["line"] == 1


def test_it_listens_on_the_loopback_address_alone(server):
    assert server.server_address[0] == "127.0.0.1"
    assert urlsplit(server.address).hostname == "127.0.0.1" and len(server.token) >= 32


def test_nobody_else_is_let_in(server):
    page, port = f"/{server.token}/", server.server_address[1]
    assert ask(server, "GET", "/")[0] == 403
    assert ask(server, "GET", "/wrong/")[0] == 403
    assert ask(server, "GET", "/%C3%A9/")[0] == 403
    assert (
        ask(server, "GET", page, Host=f"evil.example:{port}")[0] == 403
    )  # a name that was bound to this address
    assert ask(server, "GET", page, Origin="http://evil.example")[0] == 403
    assert ask(server, "GET", page, Sec_Fetch_Site="cross-site")[0] == 403
    assert ask(server, "GET", page + "motion")[0] == 404
    data = {"values": {}, "initial": {}, "until": 1}
    assert post(server, "motion", data, Origin="http://evil.example")[0] == 403
    assert post(server, "motion", data, Origin="null")[0] == 403
    assert post(server, "motion", data, Content_Type="text/plain")[0] == 403
    assert ask(server, "POST", page + "motion", json.dumps(data), Content_Type="application/json")[0] == 403
    assert post(server, "other", data)[0] == 400
    assert post(server, "motion", [1])[0] == 400
    code, _, _ = ask(
        server, "POST", page + "motion", "{}", Origin=origin(server), Content_Type="application/json",
        Content_Length=str(LARGEST_REQUEST + 1),
    )  # fmt: skip
    assert code == 400
    assert post(server, "motion", data)[0] == 200  # and the page itself still is


def test_lists_within_lists_without_end_are_refused(server):
    deep = "[" * 100_000 + "]" * 100_000
    headers = {"Origin": origin(server), "Content_Type": "application/json"}
    assert ask(server, "POST", f"/{server.token}/motion", deep, **headers)[0] == 400
    code, text, _ = post(server, "motion", {"values": {"L": 10**400}, "initial": {}, "until": 1})
    assert code == 200 and "Expected a finite number for 'L'" in unpacked(text)["error"]


def test_ctrl_c_closes_whatever_it_computes():
    """One regular expression that takes years, and in all that time lets no other instruction of Python run."""
    program = (
        "import re, threading\n"
        "from freebody.cli import main\n"
        "from freebody.cli.view import Server\n"
        "def compute():\n"
        "    print('computing', flush=True)\n"
        "    re.match('(a+)+$', 'a' * 60 + 'b')\n"
        "Server.serve_forever = lambda self, **options: threading.Thread(target=compute).run()\n"
        "main(['view', 'gyroscope', '--no-browser'])\n"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    try:
        lines = iter(process.stdout.readline, "")
        assert any(line.startswith("computing") for line in lines)
        time.sleep(0.2)
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=10) == -signal.SIGINT
        assert time.monotonic() - begun < 1
    finally:
        process.kill()
        process.stdout.close()


def test_it_closes(live):
    one = Server(live)
    thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    assert post(one, "close", {})[0] == 200
    thread.join(5)
    assert not thread.is_alive()
    one.server_close()
    with pytest.raises(OSError):
        ask(one, "GET", f"/{one.token}/")


# --- in a browser --------------------------------------------------------------------------------------------------


@pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")
def test_sliders_and_text_in_a_browser(server):
    with PageBrowser(1200, 900) as browser:
        browser.open(server.address)
        assert browser.errors == [] and browser.requests == [server.address]
        browser.wait("document.querySelector('#sliders input')")
        browser.value("freebody.seek(1); freebody.show('forces', true)")
        motions = "Number(document.documentElement.dataset.motions)"
        browser.value(
            "(s => { s.value = 2; s.dispatchEvent(new Event('input')); })"
            "(document.querySelector('input[type=range][name=L]'))"
        )
        browser.wait(f"{motions} === 2")
        state = browser.value("freebody.state")
        assert state["time"] == 1 and state["on"]["forces"]  # seen as before
        # the page computed the motion itself, and draws the longer bar
        assert browser.value("freebody.motion.scene.bodies[0].parts[0].profile[1][1]") == -1
        assert browser.requests == [server.address]
        # words that are no model: their line is marked
        browser.value(
            "(t => { t.value = t.value.replace('slender_bar', 'slender_ba'); })(document.getElementById('text'));"
            "document.getElementById('apply').click()"
        )
        browser.wait("!document.getElementById('problem').hidden")
        assert "did you mean 'slender_bar'" in browser.value("document.getElementById('problem').textContent")
        assert browser.value("document.querySelector('.wrong').textContent") == "7\n"
        browser.value(
            "(t => { t.value = t.value.replace('slender_ba', 'slender_bar').replace('\"swing\"', '\"<b>other\"'); })"
            "(document.getElementById('text')); document.getElementById('apply').click()"
        )
        browser.wait(f"{motions} === 3")
        assert browser.value("document.getElementById('problem').hidden")
        assert browser.value("document.querySelector('h1').textContent") == "<b>other"
        assert browser.errors == []


@pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")
def test_a_start_follows_its_parameter_in_a_browser():
    one = Server(machine("gyroscope", ()))
    thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()

    def move(name: str, value: float) -> str:
        return (
            f"(s => {{ s.value = {value}; s.dispatchEvent(new Event('input')); }})"
            f"(document.querySelector('input[type=range][name=\"{name}\"]'))"
        )

    def shown(name: str) -> str:
        return f"Number(document.querySelector('input[type=range][name=\"{name}\"]').value)"

    motions = "Number(document.documentElement.dataset.motions)"
    try:
        with PageBrowser(1200, 900) as browser:
            browser.open(one.address)
            browser.wait("document.querySelector('#sliders input')")
            browser.value(move("theta_0", 0.5))
            browser.wait(f"{motions} === 2")
            assert browser.value(shown("theta")) == pytest.approx(0.5)
            browser.value(move("theta", 0.8))  # the last that moved wins
            browser.wait(f"{motions} === 3")
            assert browser.value(shown("theta_0")) == pytest.approx(0.5)
            browser.value(move("theta_0", 0.6))
            browser.wait(f"{motions} === 4")
            assert browser.value(shown("theta")) == pytest.approx(0.6)
            assert browser.errors == []
    finally:
        one.shutdown()
        one.server_close()
        thread.join(5)


ARM = """<mujoco model="arm"><compiler angle="radian"/><worldbody>
<body name="upper"><joint name="shoulder" axis="0 1 0" range="-1 2.5" limited="true" stiffness="3"/>
<geom type="capsule" size="0.04" fromto="0 0 0 0 0 -1"/>
<body name="fore" pos="0 0 -1"><joint name="elbow" axis="0 1 0"/>
<geom type="capsule" size="0.04" fromto="0 0 0 0 0 -0.6"/>
<body name="rod" pos="0 0 -0.6"><joint name="reach" type="slide"/>
<geom type="box" size="0.02 0.02 0.1"/></body></body></body>
</worldbody><actuator><motor name="drive" joint="elbow"/></actuator></mujoco>"""


def test_torques_that_hold_a_robot_stand_beside_its_joints(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    live = machine(str(path), ())
    scene = live.machine()["scene"]["live"]
    assert scene["holding"] == {"shoulder": "N m", "elbow": "N m", "reach": "N"}
    sliders = {one["name"]: one for one in scene["sliders"]}
    assert (sliders["shoulder"]["low"], sliders["shoulder"]["high"]) == (-1, 2.5)  # the joint's limits
    assert [name for name, one in sliders.items() if one["group"] == "values"] == [
        "u_drive"
    ]  # masses are numbers
    if chromium() is None:
        pytest.skip("no Chromium on this machine")
    server = Server(live)
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
    units = (
        "[...document.querySelectorAll('label.slider')].map(row => row.querySelector('.unit').textContent)"
    )
    with PageBrowser() as browser:
        browser.open(server.address)
        browser.wait("document.documentElement.dataset.motions")
        for name, x in (("shoulder", 0.7), ("elbow", -0.4), ("u_drive", 0.5)):
            box = f'document.querySelector(\'input[type="number"][aria-label="{name}, number"]\')'
            browser.value(f"(box => {{box.value = {x}; box.dispatchEvent(new Event('change'))}})({box})")
        browser.wait("document.documentElement.dataset.motions >= 2")
        shown = browser.value(units)
        assert browser.errors == []
    server.shutdown()
    server.server_close()
    program = fb.compile(live.case.system)
    forces = program.inverse_dynamics([0.7, -0.4, 0.0], [0.0] * 3, [0.0] * 3, values={"u_drive": 0.5})
    assert shown[1:4] == [
        f"{of} {float(f'{x:.3g}'):g} {unit}"
        for x, of, unit in zip(forces, ("rad", "rad", "m"), ("N m", "N m", "N"), strict=True)
    ]


def test_many_sliders_of_a_kind_stand_under_a_heading(tmp_path):
    names = [f"a{k}" for k in range(13)]
    body = "".join(
        f'<body name="{x}" pos="0 0 -0.1"><joint name="{x}" axis="0 1 0"/><geom type="sphere" size="0.04"/>'
        for x in names
    )
    path = tmp_path / "chain.xml"
    path.write_text(f"<mujoco><worldbody>{body}{'</body>' * 13}</worldbody></mujoco>")
    found = machine(str(path), ()).machine()["sliders"]
    folds = {one["name"]: one.get("fold", "") for one in found}
    assert {folds[x] for x in names} == {""} and {folds[f"{x}'"] for x in names} == {"Speeds at the start"}
