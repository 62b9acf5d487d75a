"""Instants: the epoch of a scene, which is the instant of its time 0, and instants after it as seconds.

An epoch is a text such as "1992-11-09T17:49:47 UTC". Seconds between two instants are those of a clock, so a leap second of UTC
counts. Other scales of time are those of astropy: a Time, or a text such as "1992-11-09T17:49:47 TDB" where astropy is installed.
"""
from __future__ import annotations

import datetime
import importlib
import re
from fractions import Fraction
from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._given.numbers import SECONDS, numbers, refused
from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument

DAY = 86400
#: The days on which TAI - UTC became 10 s, 11 s, ..., from the Earth orientation centre's Bulletin C. Before them 10 s count.
_LEAPS = np.array([datetime.date.fromisoformat(day).toordinal() for day in """
    1972-01-01 1972-07-01 1973-01-01 1974-01-01 1975-01-01 1976-01-01 1977-01-01 1978-01-01 1979-01-01 1980-01-01
    1981-07-01 1982-07-01 1983-07-01 1985-07-01 1988-01-01 1990-01-01 1991-01-01 1992-07-01 1993-07-01 1994-07-01
    1996-01-01 1997-07-01 1999-01-01 2006-01-01 2009-01-01 2012-07-01 2015-07-01 2017-01-01""".split()])
_DIGITS = 10  #: of the seconds between two Times of astropy, which are days and so have an error of up to 2e-11 s
_ISO = re.compile(r"(\d{4}-\d\d-\d\d)(?:[T ](\d\d:\d\d)(?::(\d\d)(\.\d+)?)?)?\s*(Z|[+-]\d\d:?\d\d|[A-Za-z]+\d?)?")
_RULE = "an instant of ISO 8601 in UTC such as '1992-11-09T17:49:47Z', a datetime or a Time of astropy"


class Instant(NamedTuple):
    """Seconds since the year 1 in a scale of time. Those of UTC count its leap seconds."""

    seconds: Fraction
    scale: str = "UTC"

    def __str__(self) -> str:
        """Returns the date and time to picoseconds and the scale. A leap second reads as the second after it."""
        behind = _behind(self.seconds) if self.scale == "UTC" else 0
        day, seconds = divmod(Fraction(round((self.seconds - behind) * 10**12), 10**12), DAY)
        minutes, rest = divmod(seconds, 60)
        text = f"{float(rest):015.12f}".rstrip("0").rstrip(".")
        return f"{datetime.date.fromordinal(int(day))}T{minutes // 60:02}:{minutes % 60:02}:{text} {self.scale}"

    def after(self, seconds: float) -> Instant:
        return self._replace(seconds=self.seconds + Fraction(seconds))


def _behind(seconds: Any) -> Any:
    """Returns TAI - UTC at instants in whole seconds."""
    past = np.searchsorted(_LEAPS * DAY + 10 + np.arange(len(_LEAPS)), seconds, side="right")
    return 9 + np.maximum(past, 1).astype(object)


def is_time(given: Any) -> bool:
    """Returns whether it is a Time of astropy."""
    return hasattr(given, "isot") and hasattr(given, "scale")


def as_time(text: str) -> Any:
    """Returns an instant, such as "1992-11-09T17:49:47 TDB", as a Time of astropy. Raises ImportError without astropy."""
    date, scale = text.rsplit(maxsplit=1)
    return importlib.import_module("astropy.time").Time(date, scale=scale.lower())


def instant(path: str, given: Any, or_else: str = "") -> Instant:
    """Returns an instant that is given as a text of ISO 8601, a datetime or datetime64, or a Time of astropy; in UTC where it does
    not tell its scale or zone. `or_else`: what errors say may be given instead. Raises InvalidArgument for anything else, also for
    a leap second, which no datetime has."""
    text = given
    if is_time(given) and getattr(given, "shape", ()) == ():
        text = f"{type(given)(given, precision=9).isot} {given.scale.upper()}"
    elif isinstance(given, (datetime.date, np.datetime64)):
        text = given.isoformat() if isinstance(given, datetime.date) else str(given)
    found = _ISO.fullmatch(text.strip()) if isinstance(text, str) else None
    if found is None:
        raise refused(path, f"{shown(given)}: must be {or_else}{_RULE}")
    date, time, second, fraction, zone = found.groups()
    scale = "UTC" if zone is None or zone[0] in "Zz+-" else zone.upper()
    try:
        begun = datetime.datetime.fromisoformat(f"{date}T{time or '00:00'}:{second or '00'}")
        if scale != "UTC":
            as_time(f"{begun.isoformat()} {scale}")
        elif zone and zone[0] in "+-":
            begun -= (1 if zone[0] == "+" else -1) * datetime.timedelta(hours=int(zone[1:3]), minutes=int(zone[-2:]))
    except ImportError:
        raise refused(path, f"{shown(given)}: must be in UTC where astropy is not installed") from None
    except (ValueError, OverflowError) as error:
        raise refused(path, f"{shown(given)}: {error}" + "; no leap second is taken" * (second == "60")) from None
    past = int(np.searchsorted(_LEAPS, begun.toordinal(), side="right"))
    since = begun - datetime.datetime.min + datetime.timedelta(days=1)
    return Instant(int(since.total_seconds()) + Fraction(fraction or 0) + (9 + max(past, 1) if scale == "UTC" else 0), scale)


def epoch_text(given: Any) -> str:
    """Returns the epoch of a scene as a text with its scale."""
    return str(instant("scene.epoch", given))


def seconds_of(path: str, given: Any, epoch: Optional[str]) -> NDArray[Any]:
    """Returns times in seconds after the epoch. They are numbers of seconds, timedeltas, quantities of time, or, where the
    scene has an epoch, instants. Raises InvalidArgument that names the first that cannot be converted."""
    if epoch is None:
        try:
            return numbers(path, given, SECONDS)
        except InvalidArgument as error:
            if _has_instant(given):
                error._say(f"{error.message}; an instant needs an `epoch` in the scene")
            raise
    if is_time(given):
        return np.round(np.asarray((given - as_time(epoch)).sec, float), _DIGITS)
    if isinstance(given, (datetime.date, str, np.datetime64)):
        start, now = instant("scene.epoch", epoch), instant(path, given, "numbers of seconds, a timedelta, a quantity of time, or ")
        if now.scale != start.scale:
            raise refused(path, f"{shown(given)}: must be in the scale of the epoch {epoch}, or a Time of astropy")
        return np.array(float(now.seconds - start.seconds))
    several = isinstance(given, (list, tuple)) or getattr(getattr(given, "dtype", None), "kind", "") in ("M", "U", "O")
    if not (several and _has_instant(given)):
        return numbers(path, given, SECONDS)
    parts = [seconds_of(f"{path}[{k}]", one, epoch) for k, one in enumerate(given)]
    if any(part.ndim for part in parts):
        raise refused(path, f"{shown(given)}: must be one list of times")
    return np.array(parts, float)


def utc_of(epoch: Optional[str], seconds: NDArray[Any]) -> Optional[NDArray[np.datetime64]]:
    """Returns the instants so many seconds after an epoch in UTC, to microseconds. A leap second reads as the second after
    it. None without an epoch, for one in another scale or before 1972, and beyond 30 000 years."""
    start = None if epoch is None else instant("scene.epoch", epoch)
    if start is None or start.scale != "UTC" or start.seconds < _LEAPS[0] * DAY or np.max(np.abs(seconds), initial=0.0) > 1e12:
        return None
    now = round(start.seconds * 10**6) + np.rint(seconds * 1e6).astype(np.int64)
    since_1970 = now - (_behind(now // 10**6).astype(np.int64) + datetime.date(1970, 1, 1).toordinal() * DAY) * 10**6
    return np.asarray(since_1970.astype("datetime64[us]"))


def _has_instant(given: Any) -> bool:
    return any(isinstance(one, (datetime.date, str, np.datetime64)) or is_time(one) for one in np.ravel(np.asarray(given, object)))
