"""Instants: the epoch of a scene, which is the instant of its time 0, and instants after it as seconds.

An epoch is a text such as "1992-11-09T17:49:47 UTC": a date and time of ISO 8601 and the scale of time in which it is
counted. Seconds between two instants are those of a clock, so a leap second of UTC counts.
"""
from __future__ import annotations

import datetime
import re
from fractions import Fraction
from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._given.numbers import SECONDS, numbers, refused
from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument

#: Days from which on TAI - UTC has the number of seconds, from the Earth orientation centre's Bulletin C.
_LEAPS = tuple((datetime.date.fromisoformat(day).toordinal(), 10 + k) for k, day in enumerate("""
    1972-01-01 1972-07-01 1973-01-01 1974-01-01 1975-01-01 1976-01-01 1977-01-01 1978-01-01 1979-01-01 1980-01-01
    1981-07-01 1982-07-01 1983-07-01 1985-07-01 1988-01-01 1990-01-01 1991-01-01 1992-07-01 1993-07-01 1994-07-01
    1996-01-01 1997-07-01 1999-01-01 2006-01-01 2009-01-01 2012-07-01 2015-07-01 2017-01-01""".split()))
#: TAI minus the scale, in seconds, for the scales that differ from TAI by a constant.
_BEHIND_TAI = {"TAI": Fraction(0), "TT": Fraction(-32184, 1000), "GPS": Fraction(19)}
SCALES = ("UTC", *_BEHIND_TAI, "TDB", "TCB", "TCG", "UT1")
_DIGITS = 10  #: of the seconds between two Times of astropy, which are days and so have an error of up to 2e-11 s
_ISO = re.compile(r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))(?:[T ](\d\d):(\d\d)(?::(\d\d(?:\.\d+)?))?)?\s*(Z|[+-]\d\d:?\d\d|[A-Za-z]+\d?)?")
_RULE = f"an instant of ISO 8601 such as '1992-11-09T17:49:47 UTC', with a scale of {', '.join(SCALES)}"


class Instant(NamedTuple):
    """A day, the seconds since its beginning, and the scale in which they are counted."""

    day: int
    seconds: Fraction
    scale: str

    def __str__(self) -> str:
        minutes, seconds = divmod(self.seconds, 60)
        if minutes >= 1440:  # a leap second
            minutes, seconds = 1439, self.seconds - 1439 * 60
        text = f"{float(seconds):015.12f}".rstrip("0").rstrip(".")
        return f"{datetime.date.fromordinal(self.day)}T{minutes // 60:02}:{minutes % 60:02}:{text} {self.scale}"

    def in_tai(self) -> Optional[Fraction]:
        """Returns seconds of TAI since a fixed instant, or None for a scale that has no constant distance from TAI."""
        begun = self.day * 86400 + self.seconds
        if self.scale == "UTC":
            past = [offset for day, offset in _LEAPS if day <= self.day]
            return begun + past[-1] if past else None
        return begun + _BEHIND_TAI[self.scale] if self.scale in _BEHIND_TAI else None

    def since(self, epoch: Instant) -> Optional[float]:
        """Returns the seconds from the epoch to this instant, or None where the two scales cannot be compared."""
        if self.scale == epoch.scale and self.scale != "UTC":
            return float((self.day - epoch.day) * 86400 + self.seconds - epoch.seconds)
        now, then = self.in_tai(), epoch.in_tai()
        return None if now is None or then is None else float(now - then)

    def after(self, seconds: float) -> Instant:
        """Returns the instant so many seconds later, in the same scale."""
        then = self.in_tai() if self.scale == "UTC" else None
        for first_day, offset in reversed(_LEAPS):
            if then is None:
                break
            since = then + Fraction(seconds) - offset - first_day * 86400
            if since >= 0:
                return Instant(first_day + int(since // 86400), since % 86400, self.scale)
            if since >= -1 and first_day != _LEAPS[0][0]:  # in the leap second before that day
                return Instant(first_day - 1, 86401 + since, self.scale)
        day, rest = divmod(self.day * 86400 + self.seconds + Fraction(seconds), 86400)
        return Instant(int(day), rest, self.scale)


def instant(path: str, given: Any, scale: str = "UTC", or_else: str = "") -> Instant:
    """Returns an instant that is given as a text of ISO 8601, a datetime, a datetime64 of numpy, or a Time of astropy.

    `scale`: that of an instant that does not tell its own, such as a datetime without a time zone. `or_else`: what errors say
    may be given instead. Raises
    InvalidArgument for anything else.
    """
    if hasattr(given, "isot") and hasattr(given, "scale"):
        if getattr(given, "shape", ()) != ():
            raise refused(path, f"{shown(given)}: must be one instant")
        return instant(path, str(type(given)(given, precision=9).isot) + " " + str(given.scale).upper())
    if isinstance(given, np.datetime64):
        given = str(given)
    if isinstance(given, datetime.datetime):
        given = given.isoformat()
    elif isinstance(given, datetime.date):
        given = given.isoformat()
    if isinstance(given, Instant):
        return given
    found = _ISO.fullmatch(given.strip()) if isinstance(given, str) else None
    if found is None:
        raise refused(path, f"{shown(given)}: must be {or_else}{_RULE}")
    try:
        year, month, day_of_month, day_of_year, hours, minutes, seconds, zone = found.groups()
        day = datetime.date(int(year), int(month or 1), int(day_of_month or 1)).toordinal() + int(day_of_year or 1) - 1
        if datetime.date.fromordinal(day).year != int(year):
            raise ValueError("day is out of range for year")
    except ValueError as error:
        raise refused(path, f"{given!r}: {error}") from None
    minute, seconds, zone = int(hours or 0) * 60 + int(minutes or 0), Fraction(seconds or 0), zone or scale
    if int(hours or 0) > 23 or int(minutes or 0) > 59 or seconds >= 61:
        raise refused(path, f"{given!r}: must be {or_else}{_RULE}")
    if zone[0] in "+-":
        minute -= (int(zone[1:3]) * 60 + int(zone[-2:])) * (-1 if zone[0] == "-" else 1)
        day, minute, zone = day + minute // 1440, minute % 1440, "UTC"
    zone = "UTC" if zone == "Z" else zone.upper()
    if zone not in SCALES:
        raise refused(path, f"{given!r}: must be {or_else}{_RULE}")
    if seconds >= 60 and not (zone == "UTC" and minute == 1439 and any(day + 1 == first for first, _ in _LEAPS[1:])):
        raise refused(path, f"{given!r}: must be a second that there was: UTC has leap seconds at the ends of days alone, the last "
                            f"one before {datetime.date.fromordinal(_LEAPS[-1][0])}")
    return Instant(day, minute * 60 + seconds, zone)


def epoch_text(given: Any) -> str:
    """Returns the epoch of a scene as a text with its scale."""
    return str(instant("scene.epoch", given))


def seconds_of(path: str, given: Any, epoch: Optional[str]) -> NDArray[Any]:
    """Returns times in seconds after the epoch. They are numbers of seconds, timedeltas, quantities of time, or, where the
    scene has an epoch, instants. Raises InvalidArgument that names the first that cannot be converted."""
    if epoch is None:
        return _without_epoch(path, given)
    if hasattr(given, "isot") and hasattr(given, "scale"):
        start = instant("scene.epoch", epoch)
        if start.scale.lower() in getattr(given, "SCALES", ()):
            text, scale = str(start).split()
            return np.round(np.asarray((given - type(given)(text, scale=scale.lower())).sec, float), _DIGITS)
        return np.array([seconds_of(f"{path}[{k}]", one, epoch) for k, one in enumerate(np.ravel(given))])
    kind = getattr(getattr(given, "dtype", None), "kind", "")
    if isinstance(given, (datetime.date, str, np.datetime64)):
        start = instant("scene.epoch", epoch)
        now = instant(path, given, start.scale, "numbers of seconds, a timedelta, a quantity of time, or ")
        seconds = now.since(start)
        if seconds is None:
            raise refused(path, f"{shown(given)}: cannot be compared with the epoch {epoch}: give both in one scale, "
                                "or the times as a Time of astropy")
        return np.array(seconds)
    several = isinstance(given, (list, tuple)) or kind in ("M", "U", "O")
    if not (several and _has_instant(given)):
        return numbers(path, given, SECONDS)
    parts = [seconds_of(f"{path}[{k}]", one, epoch) for k, one in enumerate(given)]
    return np.array([part if part.ndim == 0 else _refuse(path, given) for part in parts], float)


def utc_of(epoch: Optional[str], seconds: NDArray[Any]) -> Optional[NDArray[np.datetime64]]:
    """Returns the instants so many seconds after an epoch in UTC, to microseconds. A leap second reads as the second after
    it. None without an epoch, for one in a scale that has no constant distance from TAI, and beyond 30 000 years."""
    start = None if epoch is None else instant("scene.epoch", epoch)
    begun = None if start is None else start.in_tai()
    if begun is None or np.max(np.abs(seconds), initial=0.0) > 1e12:
        return None
    now = round(begun * 10**6) + np.rint(seconds * 1e6).astype(np.int64)
    days, offsets = np.transpose(_LEAPS)
    past = np.searchsorted((days * 86400 + offsets) * 10**6, now, side="right") - 1
    since_1970 = now - (offsets[np.maximum(past, 0)] + datetime.date(1970, 1, 1).toordinal() * 86400) * 10**6
    return np.asarray(since_1970.astype("datetime64[us]"))


def _has_instant(given: Any) -> bool:
    return any(isinstance(one, (datetime.date, str, np.datetime64)) or hasattr(one, "isot") for one in np.ravel(
        np.asarray(given, object)))


def _refuse(path: str, given: Any) -> Any:
    raise refused(path, f"{shown(given)}: must be one list of times")


def _without_epoch(path: str, given: Any) -> NDArray[Any]:
    try:
        return numbers(path, given, SECONDS)
    except InvalidArgument as error:
        if _has_instant(given):
            error._say(f"{error.message}; an instant needs an `epoch` in the scene")
        raise
