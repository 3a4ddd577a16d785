"""Topics of a user's own, `user/NAME`: whoever opens one first makes it.

What the bytes of a message mean is said by a form, a short text that every reader and writer declares:
`distance_m: f64, bearing_rad: f64` names little-endian numbers without padding; any other text is a name
for bytes that the programs agree on. A reader with another form is rejected when it opens the topic.
"""

import logging
import re
import struct

import numpy as np

from . import contract as c
from .checks import Refused, header
from .errors import UsageError
from .layout import FNV_OFFSET, Topic, checksum, fnv1a, schema, u8
from .ports import Draft, View, Writer

log = logging.getLogger("zeronav")

PREFIX = "user/"
NAME = re.compile(rf"[a-z][a-z0-9_]{{0,{c.USER_NAME_BYTES_MAX - 1}}}\Z")
FORM = re.compile(rf"[!-~](?:[ -~]{{0,{c.FORM_BYTES_MAX - 2}}}[!-~])?\Z")
FIELD = re.compile(r"\s*([a-z][a-z0-9_]*)\s*:\s*([uif]\d+)\s*\Z")
NUMBERS = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i16": "h", "i32": "i", "i64": "q"}
NUMBERS |= {"f32": "f", "f64": "d"}


class Form:
    """What the bytes of a user's own topic mean."""

    def __init__(self, text):
        if not FORM.match(text):
            raise UsageError(
                f"form {text!r}: 1 to {c.FORM_BYTES_MAX} printable ASCII characters that begin and "
                "end with no space, such as `distance_m: f64`"
            )
        self.text, self.hash = text, fnv1a(FNV_OFFSET, text.encode())
        fields = [FIELD.match(part) for part in text.split(",")]
        is_record = all(field and field[2] in NUMBERS for field in fields)
        # The numbers of a record in order; None for a form that names none.
        self.numbers = tuple(field[1] for field in fields) if is_record else None
        kinds = "".join(NUMBERS[field[2]] for field in fields) if is_record else ""
        self.record = struct.Struct(f"<{kinds}") if is_record else None


def topic_of(name, form):
    """The row of the topic `name` (without the prefix) whose bytes have this form."""
    if not NAME.match(name):
        raise UsageError(
            f"user topic `{name}`: a name is a letter a to z and up to "
            f"{c.USER_NAME_BYTES_MAX - 1} more of a to z, 0 to 9 and _"
        )
    state = fnv1a(FNV_OFFSET, f"{PREFIX}{name}".encode())
    for part in (schema(c.UserEnvelope), schema(u8)):
        state = fnv1a(state, part.to_bytes(8, "little"))
    return Topic(
        number=c.EVENT_MAX,
        name=f"{PREFIX}{name}",
        discipline="latest",
        envelope=c.UserEnvelope,
        item=u8,
        writers=tuple(c.Role),
        rings=(),
        rings_in_lockstep=(),
        len_max=c.USER_BYTES_MAX,
        buffer=c.USER_BUFFER,
        pool=c.USER_POOL,
        schema=fnv1a(state, form.text.encode()),
    )


class UserWriter:
    """The writing end of a user's own topic."""

    def __init__(self, form, topic, publisher, role, epoch, bytes_max):
        self.form, self._writer = form, Writer(topic, publisher, role, epoch, bytes_max)
        self._meta = c.UserMessage(form=form.hash)

    def send(self, *numbers):
        """Sends one record of the numbers of the form; None when it was dropped."""
        if self.form.record is None:
            raise TypeError(f"the form {self.form.text!r} names no numbers: use send_bytes")
        return self.send_bytes(self.form.record.pack(*numbers))

    def send_bytes(self, data, draft=None):
        """Sends bytes. `draft` says what they were made from, if from a message of the stack."""
        items = np.frombuffer(data, np.uint8)
        return self._writer.publish(draft or Draft(), self._meta, items)


class UserReader:
    """The reading end of a user's own topic: sees every message in order, whoever wrote it."""

    def __init__(self, form, topic, subscriber):
        self.form, self.topic, self._subscriber = form, topic, subscriber
        self.refused, self._said = 0, set()

    def take(self):
        """The oldest message that has come, copied; None when there is no more.

        A tuple of the numbers of the form, a list of tuples when there are several records, or bytes.
        """
        while (sample := self._subscriber.receive()) is not None:
            view = View(self.topic, sample, 0)
            data, why = bytes(view.items), self._problem(view)
            # Given back before the next one is asked for.
            del sample, view
            if why is None:
                return self._read(data)
            self.refused += 1
            if why not in self._said:
                self._said.add(why)
                log.warning("message refused topic=%s refusal=%s", self.topic.name, why)
        return None

    def _problem(self, view):
        try:
            header(self.topic, view.header)
        except Refused as refusal:
            return str(refusal)
        if len(view.items) > c.USER_BYTES_MAX:
            return "wrong number of items"
        fits = view.header.checksum == checksum(bytes(view.envelope), view.items)
        return None if fits else "the checksum does not fit"

    def _read(self, data):
        record = self.form.record
        if record is None:
            return data
        whole = len(data) // record.size * record.size
        records = list(record.iter_unpack(data[:whole]))
        return records[0] if len(records) == 1 else records

