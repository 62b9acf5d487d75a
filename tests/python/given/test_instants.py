"""Instants with leap seconds, and out again in UTC."""
import datetime
from pathlib import Path

import numpy as np
import pytest

import stiefel
from stiefel._given.instants import instant, seconds_of, utc_of

BODY = {"system": "rigid_body", "step": 0.5, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


@pytest.mark.parametrize("text, told", [
    ("2020-06-30T23:59:60Z", "second must be in 0..59; no leap second is taken"), ("2016-12-31T23:59:60Z", "no leap second"),
    ("2026-02-29", "day is out of range for month"), ("0000-01-01", "year 0 is out of range"), ("2026-01-01T24:00Z", "hour must be in 0..23"),
    ("0001-01-01T00:00+02:00", "date value out of range"), ("2024-1-1", "must be an instant of ISO 8601 in UTC such as"),
    ("20240229", "must be an instant"), ("2026-01-01T00:00:00 XYZ", "must be in UTC where astropy is not installed|Scale 'xyz'"),
    (3.5, "must be an instant"), (None, "must be an instant")])
def test_what_is_no_instant_is_refused(text, told):
    with pytest.raises(stiefel.InvalidArgument, match=f"^epoch: {text!r}: .*({told})".replace("+", r"\+")):
        instant("epoch", text)


@pytest.mark.parametrize("given, same", [
    ("2026-03-01", "2026-03-01T00:00:00 UTC"), ("2024-02-29T12:00:00.25Z", "2024-02-29T12:00:00.25 UTC"),
    ("2017-01-01T00:59:59.123456789012+01:00", "2016-12-31T23:59:59.123456789012 UTC"), ("2012-06-30T18:29-0530", "2012-06-30T23:59:00 UTC"),
    (datetime.datetime(2026, 3, 1, 12, tzinfo=datetime.timezone(datetime.timedelta(hours=2))), "2026-03-01T10:00:00 UTC"),
    (datetime.date(2026, 3, 1), "2026-03-01T00:00:00 UTC"), (np.datetime64("2026-03-01T00:00:00.5"), "2026-03-01T00:00:00.5 UTC")])
def test_an_instant_is_read_in_every_form(given, same):
    assert str(instant("epoch", given)) == same == str(instant("epoch", same))


def test_leap_seconds_are_those_of_the_time_zone_database():
    """Its list has the first second after each, since 1900, and TAI - UTC from there on."""
    file = Path("/usr/share/zoneinfo/leap-seconds.list")
    if not file.exists():
        pytest.skip("tzdata has no leap-seconds.list")
    begin, first = np.datetime64("1900-01-01T00:00:00.000000"), instant("epoch", "1972-01-01 UTC")
    listed = [line.split()[:2] for line in file.read_text().splitlines() if line[:1].isdigit()]
    assert len(listed) == 28
    for since_1900, behind in listed[1:]:
        after = begin + np.timedelta64(int(since_1900), "s")
        elapsed = (after - np.datetime64("1972-01-01")) / np.timedelta64(1, "s") + int(behind) - 10
        assert seconds_of("times", [after, str(after - np.timedelta64(1, "s"))], str(first)).tolist() == [elapsed, elapsed - 2]
        assert str(first.after(elapsed)) == f"{after}"[:19] + " UTC"
        found = utc_of(str(first), elapsed + np.array([-2, -1, 0, 0.25]))
        assert found.tolist() == (after + np.array([-1, 0, 0, 0.25]) * np.timedelta64(10**6, "us")).tolist()


def test_utc_comes_out_where_it_went_in(tmp_path):
    run = stiefel.simulate({**BODY, "epoch": "2016-12-31T23:59:59.5 UTC"}, to=4)
    instants = ["2016-12-31T23:59:59.500000", "2017-01-01T00:00:00.000000", "2017-01-01T00:00:00.500000", "2017-01-01T00:00:00.000000",
                "2017-01-01T00:00:00.500000"]  # the second and third are in the leap second
    assert run.utc.astype(str).tolist() == instants and run[3:].utc.astype(str).tolist() == instants[3:]
    run.save(tmp_path / "run.csv")
    lines = (tmp_path / "run.csv").read_text().splitlines()
    assert lines[1].endswith(",UTC") and lines[2].endswith(",utc") and [line.rpartition(",")[2] for line in lines[3:]] == [f"{one}Z" for one in instants]
    assert stiefel.load(tmp_path / "run.csv") == run and (stiefel.load(tmp_path / "run.csv").utc == run.utc).all()
    frame = pytest.importorskip("pandas") and run.to_dataframe()
    assert (frame["utc"].to_numpy() == run.utc).all()
    with pytest.importorskip("matplotlib").rc_context():
        run.report(tmp_path / "run.html", estimate_error=False, tradeoff=False)
    assert '"utc":{"dtype":"float64"' in (tmp_path / "run.html").read_text()


@pytest.mark.parametrize("epoch", [None, "1960-01-01 UTC"])
def test_without_an_epoch_since_1972_there_is_no_utc(epoch, tmp_path):
    run = stiefel.simulate({**BODY, **({"epoch": epoch} if epoch else {})}, to=2)
    run.save(tmp_path / "run.csv")
    assert run.utc is None and "utc" not in run.to_dataframe() and "utc" not in (tmp_path / "run.csv").read_text().splitlines()[2]


def test_utc_of_far_times():
    """pandas before version 2 counts nanoseconds up to the year 2262."""
    run = stiefel.simulate({**BODY, "step": 3e9, "method": {"name": "exact"}, "epoch": datetime.datetime(2026, 3, 1)}, to=4)
    assert run.utc[4] == np.datetime64("2026-03-01") + np.timedelta64(12 * 10**15, "us")
    assert str(run.to_dataframe()["utc"].iloc[4])[:4] == "2406"
