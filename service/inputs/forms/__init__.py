"""The forms of messages on the bus: JSON, CDR of ROS 2, Keelson's envelopes, our own form."""

from __future__ import annotations

from service.inputs.forms.decoding import Undecodable, as_float, decoder, json_message, number

__all__ = ["Undecodable", "as_float", "decoder", "json_message", "number"]
