"""The page of a run: its data are those of the run, it loads nothing, and Chromium draws every panel."""
from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

import stiefel
from stiefel._report import page, run_data

SCENES = {"tumbling_spacecraft": 1200, "rigid_body_8": 200, "double_bracket": 100, "moser_veselov": 300, "stiefel": 100, "right_rigid_body": 100}
WITHOUT_BODY, IN_SPACE = {"double_bracket"}, {"tumbling_spacecraft", "moser_veselov"}


class Elements(HTMLParser):
    """Raises AssertionError for an end that fits no start, and for an id that two elements have."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.names, self.scripts = [], [], set(), []
        self.feed(text)
        assert not self.open and len(self.ids) == len(set(self.ids))

    def handle_starttag(self, tag, attrs):
        self.ids += [value for name, value in attrs if name == "id"]
        self.names |= {name for name, _ in attrs}
        if tag not in ("meta", "input"):
            self.open.append(tag)
            self.scripts += [""] * (tag == "script")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts[-1] += data


def refuse(constant):
    raise ValueError(f"{constant} is not JSON")


def read(path):
    return json.loads(Elements(path.read_text(encoding="utf-8")).scripts[0], parse_constant=refuse)


def array(part):
    values = np.frombuffer(base64.b64decode(part["data"], validate=True), part["dtype"])
    if "rows" not in part:
        return values
    values = values.reshape(-1, part["rows"], part["cols"], 2 if part["complex"] else 1)
    return values[..., 0] + 1j * values[..., 1] if part["complex"] else values[..., 0]


@pytest.mark.parametrize("name", SCENES)
def test_a_page_has_the_run_and_is_drawn(name, tmp_path):
    run = stiefel.simulate(name, to=SCENES[name])
    run.report(tmp_path / "page.html", name=name)
    shown = read(tmp_path / "page.html")
    time, fields = array(shown["samples"]["time"]), shown["samples"]["fields"]
    states = stiefel.simulate(name, **({"times": time} if "method" in run.scene else {"to": SCENES[name], "every": 1}), fields=list(fields))
    for field, part in fields.items():
        np.testing.assert_array_equal(array(part), np.asarray(states[field]).astype("c8" if part["complex"] else "f4"))
    assert len(time) > 100 and time[0] == 0 and time[-1] == pytest.approx(SCENES[name] * run.scene["step"]) and shown["numerics_id"] == run.build
    with run.origin.session(run.scene) as session:
        last = session.diagnose(to=SCENES[name], estimate_error=True)
    drifts = {family["name"]: family["drift"] for family in shown["drift"]["families"]}
    for family, drift in drifts.items():
        of = [one.drift for one in last.invariants if one.name.partition("[")[0] == family] or [last.orthogonality]
        assert drift[-1] == max(of) and len(drift) == len(shown["drift"]["time"]) == min(SCENES[name], 60) + 1
    assert (shown["tradeoff"] is None) == ("method" not in run.scene) and (shown["error"]["last"] is None) == (last.estimated_error is None)

    chromium = shutil.which("chromium")
    assert chromium, "the package chromium is missing: run docker/packages.sh browser"
    done = subprocess.run([chromium, "--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=5000",
                           "--dump-dom", (tmp_path / "page.html").as_uri()], capture_output=True, text=True, timeout=120)
    assert "CONSOLE" not in done.stderr, done.stderr
    hidden = {panel for panel, rest in re.findall(r'<figure id="(\w+)"([^>]*)>', done.stdout) if "hidden" in rest}
    assert hidden == {panel for panel, there in (("body", name not in WITHOUT_BODY), ("polhode", name in IN_SPACE), ("front", shown["tradeoff"])) if not there}
    assert done.stdout.count("<tr>") == 1 + len(drifts) and f"stiefel report {name}.json --to {SCENES[name]}" in done.stdout


def test_a_page_loads_nothing_and_no_name_ends_its_script():
    template = Elements(page.template())
    assert not template.names & {"src", "href", "srcset", "data", "action", "onclick"} and "default-src 'none'" in page.template()
    assert not re.search(r"https?:|//[a-z]+\.|url\(|@import|fetch\(|XMLHttpRequest|WebSocket|import\(", page.template())
    assert set(re.findall(r'(?:\$\("|querySelector\("#)(\w+)', template.scripts[1])) <= set(template.ids)
    block = Elements(page.html({"name": "</script><script>alert(1)</script>", "drift": float("nan")})).scripts
    assert len(block) == 2 and json.loads(block[0]) == {"name": "</script><script>alert(1)</script>", "drift": None}


def test_samples_of_long_steps_large_frames_members_and_stopped_runs(tmp_path):
    def samples(scene, to, **options):
        stiefel.simulate(scene, to=to, every=to).report(tmp_path / "page.html", estimate_error=False, tradeoff=False, **options)
        return read(tmp_path / "page.html")

    craft = dict(stiefel.examples["tumbling_spacecraft"])
    long = samples({**craft, "method": {"name": "exact"}}, 400_000)
    Q = array(long["samples"]["fields"]["Q"])
    assert long["horizon"] == 200_000 and len(Q) <= run_data.MOST + 1 and np.linalg.norm(np.diff(Q, axis=0), axis=(1, 2)).max() < 0.25
    assert len(array(samples({**craft, "step": 50}, 20)["samples"]["time"])) > 500
    M = np.random.default_rng(1).normal(size=(120, 120)) / 120
    large = {"system": "rigid_body", "inertia": 1 + np.arange(120) / 120, "step": 0.05, "method": {"name": "rk4"}, "initial": {"Q": np.eye(120), "M": M - M.T}}
    assert array(samples(large, 10)["samples"]["fields"]["Q"]).shape[1:] == (8, 8)
    assert list(samples({**large, "inertia": [1, 2, 3], "initial": {"M": [[0, -1, 2], [1, 0, -3], [-2, 3, 0]]}}, 9)["samples"]["fields"]) == ["M"]
    body = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.1}
    many = {**body, "members": 2, "body": {"moments": [1, 2, 2.7], "angular_velocity": [[0.3, 1, 0.2], [1, 0.2, 0.3]]}}
    shown = samples(many, 200, member=1)
    alone = stiefel.simulate({**body, "body": {"moments": [1, 2, 2.7], "angular_velocity": [1, 0.2, 0.3]}}, times=array(shown["samples"]["time"]), fields="Q")
    assert shown["member"] == 1 and (array(shown["samples"]["fields"]["Q"]) == alone["Q"].astype("f4")).all()
    with pytest.raises(stiefel.InvalidArgument, match="member: 2: is not a member of the scene"):
        samples(many, 5, member=2)
    with stiefel.simulate({**body, "step": 20, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 1, 1]}}, to=0).origin.session({}) as session:
        stopped = page.data(session, 100, tradeoff=False)
    assert stopped["outcome"] == "LEFT_DOMAIN" and stopped["to"] == 0 and "principal branch" in stopped["message"]
