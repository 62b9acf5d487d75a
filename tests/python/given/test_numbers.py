"""Numbers with and without units: converted where they have a meaning, else refused by name before anything moves."""
import datetime
import decimal
import fractions
from types import SimpleNamespace

import numpy as np
import pytest

import stiefel

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.5,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 0.2, 0.1]}}
IN = {("min", "s"): 60.0, ("ms", "s"): 1e-3, ("deg/s", "rad/s"): np.pi / 180, ("g*cm**2", "kg*m**2"): 1e-7}


class Quantity:
    """As of pint: it converts itself, and forgets its unit as an array."""

    def __init__(self, magnitude, units):
        self.magnitude, self.units = np.asarray(magnitude), units

    def to(self, unit):
        if (self.units, unit) not in IN:
            raise RuntimeError(f"cannot convert {self.units} to {unit}")
        return Quantity(self.magnitude * IN[self.units, unit], unit)

    def __array__(self, *arguments, **more):
        return self.magnitude

    def __float__(self):
        return float(self.magnitude)

    def __index__(self):
        return int(self.magnitude)


class Subclass(np.ndarray):
    """As of astropy: an array, whose values in another unit are `to(unit).value`."""

    @staticmethod
    def of(values, unit):
        array = np.asarray(values, float).view(Subclass)
        array.unit = unit
        return array

    def to(self, unit):
        return SimpleNamespace(value=np.asarray(self) * IN[self.unit, unit])


@pytest.fixture(scope="module")
def session(client):
    with client.create(SCENE) as session:
        yield session


@pytest.mark.parametrize("times", [
    [60.0, 120.0], (60, np.float64(120)), np.array([60, 120], "i4"), np.array([1, 2], "m8[m]"), np.array([60_000, 120_000], "m8[ms]"),
    [np.timedelta64(1, "m"), np.timedelta64(120, "s")], [datetime.timedelta(minutes=1), 120.0],
    np.array([datetime.timedelta(minutes=k) for k in (1, 2)]), [decimal.Decimal(60), fractions.Fraction(120)],
    Quantity([1, 2], "min"), [Quantity(1, "min"), Quantity(120_000, "ms")], Subclass.of([1, 2], "min"), range(60, 121, 60)])
def test_what_is_a_time_is_taken_in_seconds(session, times):
    assert list(session.trajectory(times=times).time) == [60, 120]


@pytest.mark.parametrize("times", [
    np.array(["2020-01-01"], "M8[s]"), [np.datetime64("2020-01-01")], [datetime.datetime(2020, 1, 1)], datetime.date(2020, 1, 1),
    [1 + 2j], ["1.5"], "1 day", b"1", True, [1.0, True], [None], {1: 2.0}, object(), Quantity([1, 2], "m"), [1.0, Quantity(1, "m")],
    Subclass.of([1, 2], "m"), np.timedelta64(3), np.timedelta64(3, "M"), np.ma.array([1.0, 2.0], mask=[False, True]), [10**400]])
def test_what_is_no_time_is_refused_by_name(session, times):
    with pytest.raises(stiefel.InvalidArgument, match="^times: .*: must be numbers of seconds") as caught:
        session.trajectory(times=times)
    assert caught.value.violations[0].field == "times"


MINUTE = [60.0, np.timedelta64(1, "m"), datetime.timedelta(minutes=1), Quantity(1, "min"), Subclass.of(1, "min")]


@pytest.mark.parametrize("minute", MINUTE)
def test_every_time_may_have_a_unit(client, session, minute):
    frame, other = [[1.0, 0.0]], [[0.0, 1.0]]
    turned = client.geodesics([(frame, other)], inertia=[1, 1], time=minute)[0]
    # A quarter of a circle in 60 s: 1/2 (pi/2/60)^2 60 for Lambda = I.
    assert turned.energy == pytest.approx(np.pi**2 / 8 / 3600, rel=1e-12)
    scene = stiefel.to_message({**SCENE, "step": minute, "horizon": minute, "tolerance": 1e-6})
    assert (scene.step, scene.horizon) == (60, 60)
    with session.fork(at=0, step=minute) as fork:
        assert fork.scene["step"] == 60
    assert session.step(to=3, timeout=minute).step == 3
    with stiefel.Client(client.address, timeout=minute) as other_client:
        assert other_client.timeout == 60 and other_client.describe().systems
    found = stiefel.sweep(SCENE, axes={"step": [0.5, minute]}, to=1, summarize={"energy": "last"}, servers=[client])
    assert list(found["step"].values if hasattr(found["step"], "values") else found["step"]) == [0.5, 60]
    assert client.tradeoff({**SCENE, "step": 10.0}, horizon=minute, budget=1e8, repeats=1).horizon == 60


@pytest.mark.parametrize("wrong", [Quantity(1, "m"), "1", True, 1j, np.datetime64("2020"), [1.0], np.array([1.0, 2.0])])
def test_no_time_drops_its_unit(client, session, wrong):
    frame = [[1.0, 0.0]]
    for name, call in {
        "time": lambda: client.geodesics([(frame, frame)], inertia=[1, 1], time=wrong)[0],
        "horizon": lambda: client.tradeoff(SCENE, horizon=wrong),
        "timeout": lambda: session.step(to=1, timeout=wrong),
        "scene.horizon": lambda: client.create({**SCENE, "horizon": wrong}),
        "step": lambda: session.fork(at=0, step=wrong),
    }.items():
        if name == "scene.horizon" and isinstance(wrong, str):
            continue  # protobuf's JSON has numbers as texts
        with pytest.raises(stiefel.InvalidArgument, match=f"^{name}: "):
            call()
    with pytest.raises(stiefel.InvalidArgument, match="^timeout: "):
        stiefel.Client(timeout=wrong)


@pytest.mark.parametrize("make", [Quantity, Subclass.of])
def test_a_body_may_have_units(make):
    scene = stiefel.to_message({**SCENE, "body": {"moments": make([1e7, 2e7, 3e7], "g*cm**2"),
                                                  "angular_velocity": make([180, 0, 90], "deg/s")}})
    assert list(scene.body.moments) == pytest.approx([1, 2, 3]) == [1, 2, 3]
    assert list(scene.body.angular_velocity) == pytest.approx([np.pi, 0, np.pi / 2])
    for body in ({"moments": make([1, 2, 3], "kg")}, {"attitude": make([1, 0, 0, 0], "deg/s")}):
        with pytest.raises(stiefel.InvalidArgument, match=f"scene.body.{next(iter(body))}: .* must be numbers"):
            stiefel.to_message({**SCENE, "body": body})
    for change in ({"inertia": make([1, 2, 3], "m")}, {"epsilon": make(1, "m")}, {"initial": {"M": make(np.eye(3), "m")}}):
        with pytest.raises(stiefel.InvalidArgument, match="must be .*numbers without a unit"):
            stiefel.to_message({**SCENE, **change})


@pytest.mark.parametrize("given", [30, 30.0, np.float64(30), np.int16(30), np.array(30), decimal.Decimal(30), fractions.Fraction(60, 2)])
def test_a_whole_number_may_be_of_any_type(session, client, given):
    assert session.step(to=given).step == session.trajectory(to=given, start=given).step[-1] == 30
    assert list(session.trajectory(to=given, every=given).step) == [0, 30]
    assert [batch.step[-1] for batch in session.stream(to=given)][-1] == session.diagnose(to=given).step == 30
    with session.drive() as drive, session.fork(at=given) as fork:
        assert drive.step(given).step == 30 and (fork.step(0, fields="Q")["Q"] == session.step(30, fields="Q")["Q"]).all()
    assert session.summarize(given, quantities={"energy": "last"}, every=given).samples == 2
    assert session.events(given, events={"field": "Q", "coefficients": np.ones(9), "limit": given}).run_status.outcome == "REACHED"
    assert client.geodesics([([[1, 0]], [[0, 1]])], inertia=[1, 1], samples=given, steps=given)[0].trajectory.shape == (31, 1, 2)


@pytest.mark.parametrize("given", [100.5, np.float64(0.1), "3", True, None, 1j, [3], np.array([3]), np.nan, np.inf, datetime.timedelta(3),
                                   Quantity(3, "min"), decimal.Decimal("1.5")])
def test_what_is_no_whole_number_is_refused_by_name(session, given):
    needed = {} if given is None else {"to": session.step, "at": session.fork}  # without them the time must be given
    for name, call in {**needed, "start": lambda start: session.trajectory(to=3, start=start),
                       "every": lambda every: session.summarize(3, quantities={"energy": "last"}, every=every)}.items():
        with pytest.raises(stiefel.InvalidArgument, match=f"^{name}: .*: must be a whole number of at least [01].* `times` of"):
            call(given)


def test_samples_are_at_least_a_step_apart_and_times_before_0_need_a_negative_step(session):
    for call in (lambda: session.trajectory(to=3, every=0), lambda: next(session.stream(to=3, every=0)),
                 lambda: session.trajectory(time=0.055, every=0), lambda: session.summarize(3, quantities={"energy": "last"}, every=0)):
        with pytest.raises(stiefel.InvalidArgument, match="^every: 0: must be a whole number of at least 1$"):
            call()
    with pytest.raises(stiefel.InvalidArgument, match="^to: -1: must be .* for times before 0, use a negative step in the scene"):
        session.trajectory(to=-1)


@pytest.mark.parametrize("call, told", [
    (lambda client, session: session.step(to=3, fields=3), "fields: 3: must be a name or several"),
    (lambda client, session: session.diagnose(to=3, invariants=3), "invariants: 3: must be a name or several"),
    (lambda client, session: session.diagnose(to=3, estimate_error="yes"), "estimate_error: 'yes': must be True, False or None"),
    (lambda client, session: session.diagnose(to=3, forms=3), "forms: 3: must be a list, each of a name and two tangent vectors"),
    (lambda client, session: session.diagnose(to=3, forms=[["omega"]]), r"forms\[0\]: \['omega'\]: must be a name and two"),
    (lambda client, session: session.diagnose(to=3, forms=[["omega", 1, 2]]), r"forms\[0\].first: 1: must be a mapping"),
    (lambda client, session: session.diagnose(to=3, dirac_brackets=[[1, 2]]), r"dirac_brackets\[0\].first: 1: must be a list"),
    (lambda client, session: client.geodesics(3, inertia=[1, 1]), "pairs: 3: must be several pairs of frames"),
    (lambda client, session: client.geodesics([([[1, 0]], [[0, 1]])], inertia=[1, 1], restarts=2**32)[0], "restarts: 4294967296: .* below 2.32$"),
    (lambda client, session: client.get(3), "id: 3: must be a text"),
    (lambda client, session: client.delete(3), "id: 3: must be a text"),
    (lambda client, session: client.create(SCENE, id=3), "id: 3: must be a text"),
    (lambda client, session: client.convert(SCENE, system=3), "system: 3: must be a text"),
    (lambda client, session: session.fork(at=0, system=3), "system: 3: must be a text"),
    (lambda client, session: stiefel.Client(3), "address: 3: must be a text"),
    (lambda client, session: session.covariance(np.diag([1, 1, 1, 1, 1, np.nan]), to=3), "P0: nan: must be finite")])
def test_an_argument_of_a_wrong_kind_is_named(client, session, call, told):
    with pytest.raises(stiefel.InvalidArgument, match=f"^{told}"):
        call(client, session)
