"""The validity of the certificates of a Zenoh file, and the cure before, after and close to its end.

What a vehicle needs suffices: the dates are read from the certificate itself (RFC 5280, Section 4.1), without the
package that makes certificates.
"""

from __future__ import annotations

import base64
import binascii
import re
import ssl
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

WARNING_SPAN = timedelta(days=30)
"""The time before its end in which a certificate is said to end: a month leaves time for a visit to the vehicle."""
EARLIEST_CLOCK = datetime(2020, 1, 1, tzinfo=UTC)
"""The time from which our certificates are valid (`service.security.authority`): a clock that says less is wrong."""
_PEM = re.compile(rb"-----BEGIN CERTIFICATE-----.+?-----END CERTIFICATE-----", re.DOTALL)
_UTC_TIME, _GENERALIZED_TIME, _VERSION = 0x17, 0x18, 0xA0


@dataclass(frozen=True, slots=True)
class Validity:
    """The time span in which the certificates of a file are valid.

    Attributes:
        path: where they are.
        begins, ends: all of them are valid from the one to the other.
        authority: whether it is the one that signs the others.
    """

    path: Path
    begins: datetime
    ends: datetime
    authority: bool = False

    @property
    def cure(self) -> str:
        """The command that makes another one."""
        role = "" if self.authority else f" --role {self.path.stem}"
        what = "the authority and all keys anew" if self.authority else "another one"
        return f"`incsvr keys {self.path.parent}{role} --replace` makes {what} (--prefix and --listen as before)"

    def sentence_now(self) -> str | None:
        """The sentence at the time of the clock on the wall."""
        return self.sentence(now())

    @property
    def refused_now(self) -> bool:
        """Whether it is not accepted now."""
        return not self.authority and not self.begins <= now() <= self.ends

    def sentence(self, now: datetime) -> str | None:
        """The fault of a certificate at this time, or soon, with the cure; None without one."""
        if now < self.begins:  # of an authority that says nothing more: what it signed is not valid either
            return None if self.authority else not_yet_valid(f"the certificate {self.path}", self.begins, now)
        if now > self.ends:
            who = "other programs than Zenoh do not go by it" if self.authority else "nobody accepts it"
            return (
                f"the certificate {self.path} ended on {self.ends:%Y-%m-%d}, and {who} any more: {self.cure}; then "
                "start again"
            )
        if now > self.ends - WARNING_SPAN:
            days = (self.ends - now).days
            return f"the certificate {self.path} ends on {self.ends:%Y-%m-%d}, in {days} days: {self.cure}"
        return None


def not_yet_valid(what: str, begins: datetime, now: datetime) -> str:
    """A certificate that is not valid yet: by a clock that is wrong, or because it was made so."""
    clock = f"the clock of this machine says {now:%Y-%m-%d %H:%M} UTC"
    cure = "`timedatectl set-ntp true`, or `date -s`"
    if now < EARLIEST_CLOCK:
        return f"{clock}, and {what} is valid from {begins:%Y-%m-%d} on: set the clock ({cure})"
    return f"{what} is valid from {begins:%Y-%m-%d %H:%M} UTC on, and {clock}: set it if it is wrong ({cure}), or wait"


def now() -> datetime:
    """The time by the clock on the wall."""
    return datetime.now(UTC)


def validities(tls: Mapping[str, Any]) -> tuple[Validity, ...]:
    """The validity of all certificates that a TLS section names; an unreadable one is left to who opens it."""
    return tuple(_validities(tls))


def _validities(tls: Mapping[str, Any]) -> Iterator[Validity]:
    for name in ("listen_certificate", "connect_certificate", "root_ca_certificate"):
        path, inline = tls.get(name), tls.get(f"{name}_base64")
        try:
            content = Path(path).read_bytes() if path else base64.b64decode(inline or "", validate=True)
            found = [dates(ssl.PEM_cert_to_DER_cert(pem.decode())) for pem in _PEM.findall(content)]
        except (OSError, ValueError, IndexError, binascii.Error):
            continue
        if found:
            begins, ends = max(each[0] for each in found), min(each[1] for each in found)
            yield Validity(Path(path or f"{name}_base64"), begins, ends, authority=name.startswith("root"))


def dates(der: bytes) -> tuple[datetime, datetime]:
    """The begin and end of a certificate's validity.

    Raises:
        ValueError, IndexError: it is none.
    """
    _, at, _ = _element(der, 0)  # Certificate
    _, at, _ = _element(der, at)  # tbsCertificate
    tag, _, end = _element(der, at)
    at = end if tag == _VERSION else at
    for _ in ("serialNumber", "signature", "issuer"):
        at = _element(der, at)[2]
    _, at, _ = _element(der, at)  # validity
    begins, after = _time(der, at)
    return begins, _time(der, after)[0]


def _element(der: bytes, at: int) -> tuple[int, int, int]:
    """Tag of the element that begins here, where its content begins and where it ends."""
    tag, length, start = der[at], der[at + 1], at + 2
    if length & 0x80:
        count = length & 0x7F
        length, start = int.from_bytes(der[start : start + count], "big"), start + count
    return tag, start, start + length


def _time(der: bytes, at: int) -> tuple[datetime, int]:
    tag, start, end = _element(der, at)
    text = der[start:end].decode("ascii")
    if tag == _UTC_TIME:  # two digits of the year, from 1950 to 2049
        text = ("19" if text[:2] >= "50" else "20") + text
    elif tag != _GENERALIZED_TIME:
        raise ValueError("this is no time of a certificate")
    return datetime.strptime(text, "%Y%m%d%H%M%SZ").replace(tzinfo=UTC), end
