"""The reason why a TLS endpoint refuses a client: Zenoh gives none, so a handshake of our own finds it."""

from __future__ import annotations

import re
import socket
import ssl
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import zenoh

from service.security.certificate_validity import dates, not_yet_valid, now, validities
from service.security.zenoh_file import endpoints, tls_section

STEP_TIMEOUT_S = 2.0
"""The time that the other side may take for each step [s]."""
_NO_TLS = frozenset({"WRONG_VERSION_NUMBER", "RECORD_LAYER_FAILURE", "PACKET_LENGTH_TOO_LONG", "HTTP_REQUEST"})
_ANOTHER = "on its machine `incsvr keys DIR --role learner --replace` makes another; then restart the server there"


def refusal(config: zenoh.Config) -> str | None:
    """The reason why a client's first TLS endpoint refuses it, and the cure; None if it is unknown."""
    for own in validities(config):
        if own.refused_now:
            return own.sentence_now()
    tls = tls_section(config)
    for endpoint in endpoints(config, "connect"):
        found = re.fullmatch(r"tls/\[?([^\]/]+?)\]?:(\d+)(?:[?#].*)?", endpoint)
        if found is None:
            continue
        try:
            return _handshake_sentence(endpoint, (found[1], int(found[2])), tls)
        except (OSError, ValueError, OverflowError):
            continue  # nobody listens, or what is named here cannot be read
    return None


def _handshake_sentence(endpoint: str, place: tuple[str, int], tls: Mapping[str, Any]) -> str | None:
    try:
        with _handshake(place, _context(tls)) as met:
            sentence = _date_sentence(endpoint, met.getpeercert(binary_form=True) or b"") or _admission_sentence(
                endpoint, met, tls
            )
    except ssl.SSLError as error:
        return _alert(endpoint, error, tls)
    if sentence is not None:
        return sentence
    try:
        with _handshake(place, _context(tls, verified=True)):
            return None
    except ssl.SSLCertVerificationError as error:
        return (
            f"the certificate of the server at {endpoint} is not accepted: {error.verify_message}; use the files that "
            "`incsvr keys` made with its own, and the endpoint that they name"
        )


def _date_sentence(endpoint: str, der: bytes) -> str | None:
    begins, ends = dates(der)
    if now() > ends:
        return f"the certificate of the server at {endpoint} ended on {ends:%Y-%m-%d}: {_ANOTHER}"
    if now() < begins:
        return not_yet_valid(f"the certificate of the server at {endpoint}", begins, now())
    return None


def _admission_sentence(endpoint: str, met: ssl.SSLSocket, tls: Mapping[str, Any]) -> str | None:
    """The other side's answer to our certificate, which TLS 1.3 sends after the handshake."""
    try:
        met.recv(1)
    except ssl.SSLError as error:
        return _alert(endpoint, error, tls)
    except TimeoutError:
        return None
    return None


def _alert(endpoint: str, error: ssl.SSLError, tls: Mapping[str, Any]) -> str | None:
    reason, own = (error.reason or str(error)).replace("_", " ").lower(), tls.get("connect_certificate")
    if own and "alert" in reason and "expired" in reason:
        return (
            f"the server at {endpoint} refuses the certificate {own} as expired, but by this machine's clock, "
            f"{now():%Y-%m-%d %H:%M} UTC, it is valid: set the clock of the other machine (`timedatectl set-ntp true`)"
        )
    if "alert" in reason and ("unknown ca" in reason or "certificate" in reason):
        shown = f"the certificate {own}" if own else "a client without a certificate"
        return (
            f"the server at {endpoint} refuses {shown} ({reason}); use the files that `incsvr keys` made with its own"
        )
    if error.reason in _NO_TLS:
        return f"the server at {endpoint} speaks no TLS; write tcp/ in place of tls/, or use a secured bus"
    return None  # such as one that ends just now


def _context(tls: Mapping[str, Any], verified: bool = False) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = verified and tls.get("verify_name_on_connect") is not False
    context.verify_mode = ssl.CERT_REQUIRED if verified else ssl.CERT_NONE
    if verified:
        context.load_verify_locations(tls["root_ca_certificate"])
    certificate, key = tls.get("connect_certificate"), tls.get("connect_private_key")
    if certificate and key:
        context.load_cert_chain(Path(certificate), Path(key))
    return context


def _handshake(place: tuple[str, int], context: ssl.SSLContext) -> ssl.SSLSocket:
    raw = socket.create_connection(place, STEP_TIMEOUT_S)
    try:
        return context.wrap_socket(raw, server_hostname=place[0])
    except BaseException:
        raw.close()
        raise
