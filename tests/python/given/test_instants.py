"""Instants with leap seconds and days of the year, and out again in UTC."""
import datetime
from pathlib import Path

import numpy as np
import pytest

import stiefel
from stiefel._given.instants import instant, utc_of

BODY = {"system": "rigid_body", "step": 0.5, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


@pytest.mark.parametrize("text", ["2026-06-30T23:59:60 UTC", "2016-12-30T23:59:60Z", "1971-12-31T23:59:60 UTC", "2016-12-31T22:59:60 UTC",
                                  "2016-12-31T23:59:60+01:00", "2016-12-31T23:59:60 TAI", "2016-12-31T23:59:61 UTC"])
def test_a_leap_second_that_never_was_is_refused(text):
    with pytest.raises(stiefel.InvalidArgument, match=r"epoch: '.*': must be a"):
        instant("epoch", text)


@pytest.mark.parametrize("text, same", [
    ("2016-366T23:59:60.5 UTC", "2016-12-31T23:59:60.5 UTC"), ("2017-01-01T00:59:60+01:00", "2016-12-31T23:59:60 UTC"),
    ("2012-182T18:29:60-05:30", "2012-06-30T23:59:60 UTC"), ("2026-001", "2026-01-01T00:00:00 UTC"),
    ("2024-060T12:00:00.25Z", "2024-02-29T12:00:00.25 UTC"), ("2023-060T12:00 TDB", "2023-03-01T12:00:00 TDB")])
def test_leap_seconds_and_days_of_the_year_are_read(text, same):
    assert str(instant("epoch", text)) == same


@pytest.mark.parametrize("text", ["2023-366", "2024-367T00:00:00", "2024-000", "2024-1-1", "2024-02-30", "20240229"])
def test_a_day_that_is_none_is_refused(text):
    with pytest.raises(stiefel.InvalidArgument, match="epoch: "):
        instant("epoch", text)


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
        last = instant("epoch", str(after - np.timedelta64(1, "s"))[:17] + "60")
        assert str(last) == str(first.after(elapsed - 1)) and last.since(first) == elapsed - 1
        found = utc_of(str(first), elapsed + np.array([-2, -1, 0, 0.25]))
        assert found.tolist() == (after + np.array([-1, 0, 0, 0.25]) * np.timedelta64(10**6, "us")).tolist()


@pytest.mark.parametrize("epoch, utc", [("2025-06-01T00:00:18 GPS", "2025-06-01"), ("2020-01-01T00:01:09.184 TT", "2020-01-01"),
                                        ("1980-002T00:00:19 TAI", "1980-01-02"), ("2026-03-01T02:00+02:00", "2026-03-01")])
def test_utc_of_other_scales(epoch, utc):
    assert utc_of(epoch, np.array([0.0, -1.5])).tolist() == (np.datetime64(utc, "us") - np.array([0, 1_500_000])).tolist()


def test_utc_comes_out_where_it_went_in(tmp_path):
    run = stiefel.simulate({**BODY, "epoch": "2016-12-31T23:59:59.5 UTC"}, to=4)
    instants = ["2016-12-31T23:59:59.500000", "2017-01-01T00:00:00.000000", "2017-01-01T00:00:00.500000", "2017-01-01T00:00:00.000000",
                "2017-01-01T00:00:00.500000"]  # the second and third are in the leap second
    assert run.utc.astype(str).tolist() == instants and run[3:].utc.astype(str).tolist() == instants[3:]
    run.save(tmp_path / "run.csv")
    lines = (tmp_path / "run.csv").read_text().splitlines()
    assert lines[1].endswith(",UTC") and lines[2].endswith(",utc") and [line.rpartition(",")[2] for line in lines[3:-1]] == [f"{one}Z" for one in instants]
    assert stiefel.load(tmp_path / "run.csv") == run and (stiefel.load(tmp_path / "run.csv").utc == run.utc).all()
    frame = pytest.importorskip("pandas") and run.to_dataframe()
    assert (frame["utc"].to_numpy() == run.utc).all()
    with pytest.importorskip("matplotlib").rc_context():
        run.report(tmp_path / "run.html", estimate_error=False, tradeoff=False)
    assert '"utc":{"dtype":"float64"' in (tmp_path / "run.html").read_text()


@pytest.mark.parametrize("epoch", [None, "2016-12-31T23:59:59.5 TDB", "1960-01-01 UTC"])
def test_without_an_epoch_of_a_known_distance_from_utc_there_is_none(epoch, tmp_path):
    run = stiefel.simulate({**BODY, **({"epoch": epoch} if epoch else {})}, to=2)
    run.save(tmp_path / "run.csv")
    assert run.utc is None and "utc" not in run.to_dataframe() and "utc" not in (tmp_path / "run.csv").read_text().splitlines()[2]


def test_utc_of_far_times():
    """pandas before version 2 counts nanoseconds up to the year 2262."""
    run = stiefel.simulate({**BODY, "step": 3e9, "method": {"name": "exact"}, "epoch": datetime.datetime(2026, 3, 1)}, to=4)
    assert run.utc[4] == np.datetime64("2026-03-01") + np.timedelta64(12 * 10**15, "us")
    assert str(run.to_dataframe()["utc"].iloc[4])[:4] == "2406"
