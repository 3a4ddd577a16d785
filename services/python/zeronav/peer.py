"""A member of a domain with its ports."""

import select
import socket
import time
import os

import iceoryx2 as iox2

from . import contract as c
from . import memory
from .clock import now_ns
from .errors import ContractError, StartError, UsageError
from .ports import Latest, SpanWriter, Stream, Writer
from .user import Form, UserReader, UserWriter, topic_of

OPEN_TRIES = 20
OPEN_PAUSE_S = 0.005
WAKE_AT_LEAST_NS = 50_000_000

PROBLEMS = {
    "IncompatibleTypes": "its messages have another type than this package knows",
    "IncompatibleAttributes": "its messages have other fields than this package knows "
    "(schema hash differs)",
    "DoesNotExist": "does not exist in this domain",
    "VersionMismatch": "made by another version of the middleware",
}


class Peer:
    """A member of `domain` in the seat `role`, started as the `epoch`-th."""

    def __init__(self, domain, role, epoch):
        self.domain, self.role, self.epoch = domain, role, epoch
        iox2.set_log_level(iox2.LogLevel.Fatal)
        builder = iox2.NodeBuilder.new().config(domain.config())
        builder = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled)
        try:
            self._node = builder.create(iox2.ServiceType.Ipc)
        except Exception as error:
            raise StartError(f"joining the domain: {error}") from error
        self._ports = []

    def leave(self):
        """Closes every port, then leaves the middleware."""
        for port in self._ports:
            port.delete()
        self._ports.clear()
        self._node = None

    def _keep(self, port):
        self._ports.append(port)
        return port

    def _open(self, topic):
        key = iox2.AttributeKey.new("schema")
        value = iox2.AttributeValue.new(f"{topic.schema:016x}")
        verifier = iox2.AttributeVerifier.new().require(key, value)
        payload = topic.item if topic.envelope is None else iox2.Slice[topic.item]
        for attempt in range(OPEN_TRIES + 1):
            builder = self._node.service_builder(iox2.ServiceName.new(topic.name))
            builder = builder.publish_subscribe(payload)
            if topic.envelope is not None:
                builder = builder.user_header(topic.envelope)
            try:
                return builder.open_with_attributes(verifier)
            except Exception as error:
                problem = PROBLEMS.get(str(error))
                if problem:
                    raise ContractError(topic.name, problem) from error
                # Opening may meet a cleanup that is under way; that passes.
                if attempt == OPEN_TRIES:
                    raise StartError(f"opening topic {topic.name}: {error}") from error
                time.sleep(OPEN_PAUSE_S)

    def _subscriber(self, topic, factory=None):
        try:
            builder = (factory or self._open(topic)).subscriber_builder().buffer_size(topic.buffer)
            return self._keep(builder.create())
        except StartError:
            raise
        except Exception as error:
            raise StartError(f"reading {topic.name}: {error}") from error

    def _publisher(self, topic, length, factory=None):
        memory.check(topic.segment_bytes(length))
        factory = factory or self._open(topic)
        try:
            builder = factory.publisher_builder().max_loaned_samples(1)
            if topic.envelope is not None:
                builder = builder.initial_max_slice_len(max(1, length))
            builder = builder.override_sample_preallocation(topic.pool)
            publisher = self._keep(builder.create())
        except Exception as error:
            raise StartError(f"writing {topic.name}: {error}") from error
        self.domain.reserve(publisher.id.value, topic.name)
        return publisher

    def latest(self, topic):
        """A reader that keeps the newest message."""
        return Latest(topic, self._subscriber(topic))

    def stream(self, topic):
        """A reader that sees every message in order."""
        return Stream(topic, self._subscriber(topic))

    def writer(self, topic, length=1):
        """The writer of `topic` with slices of up to `length` items."""
        if length > topic.len_max:
            most = f"the contract allows {topic.len_max}"
            raise UsageError(f"topic {topic.name}: {length} items asked, {most}")
        return Writer(topic, self._publisher(topic, length), self.role, self.epoch, length)

    def user_writer(self, name, form, bytes_max=64):
        """The writer of the user's own topic `name` (without its prefix), whose messages of up to
        `bytes_max` bytes are what the text `form` says, see `zeronav.user`."""
        form = Form(form)
        if not 0 <= bytes_max <= c.USER_BYTES_MAX:
            raise UsageError(f"user topic {name}: at most {c.USER_BYTES_MAX} bytes, not {bytes_max}")
        topic = topic_of(name, form)
        publisher = self._publisher(topic, bytes_max, self._open_user(topic, form))
        return UserWriter(form, topic, publisher, self.role, self.epoch, bytes_max)

    def user_reader(self, name, form):
        """A reader of the user's own topic `name` (without its prefix)."""
        form = Form(form)
        topic = topic_of(name, form)
        return UserReader(form, topic, self._subscriber(topic, self._open_user(topic, form)))

    def _open_user(self, topic, form):
        """Opens the topic, or makes it."""
        verifier = iox2.AttributeVerifier.new()
        for key, value in (("schema", f"{topic.schema:016x}"), ("form", form.text)):
            key, value = iox2.AttributeKey.new(key), iox2.AttributeValue.new(value)
            verifier = verifier.require(key, value)

        def builder():
            name = iox2.ServiceName.new(topic.name)
            made = self._node.service_builder(name).publish_subscribe(iox2.Slice[topic.item])
            made = made.user_header(topic.envelope).history_size(0).enable_safe_overflow(True)
            made = made.subscriber_max_buffer_size(c.USER_BUFFER).max_nodes(c.NODES_MAX)
            made = made.subscriber_max_borrowed_samples(c.USER_BORROWED)
            return made.max_publishers(c.WRITERS_MAX).max_subscribers(c.READERS_MAX)

        for attempt in range(OPEN_TRIES + 1):
            try:
                return builder().open_or_create_with_attributes(verifier)
            except Exception as error:
                if "IncompatibleAttributes" in str(error):
                    problem = self._other_form(builder(), form)
                    raise ContractError(topic.name, problem) from error
                # Opening may meet a cleanup that is under way; that passes.
                if attempt == OPEN_TRIES:
                    raise StartError(f"opening topic {topic.name}: {error}") from error
                time.sleep(OPEN_PAUSE_S)

    def _other_form(self, builder, form):
        """What is wrong with a topic that has another form."""
        try:
            attributes = builder.open().attributes.values
            forms = (one.value for one in attributes if one.key.to_string() == "form")
            other = next(forms).to_string()
        except Exception:
            return PROBLEMS["IncompatibleAttributes"]
        return (
            f'its form is "{other}", and this program expects "{form.text}": '
            "declare the same text in both"
        )

    def span_writer(self):
        """The writer of `run/spans`."""
        return SpanWriter(self._publisher(c.RUN_SPANS, 1))

    def _bell(self, role):
        name = f"doorbell/{role.name.lower()}"
        try:
            return self._node.service_builder(iox2.ServiceName.new(name)).event().open()
        except Exception as error:
            raise StartError(f"opening {name}: {error}") from error

    def doorbell(self, signals):
        """The own doorbell; `signals` is a socket that becomes readable on a signal."""
        before = _sockets()
        listener = self._keep(self._bell(self.role).listener_builder().create())
        # The binding does not hand the descriptor out: it is the socket that is new.
        new = [fd for fd in _sockets() - before if self._is_bell(fd)]
        if len(new) != 1:
            raise StartError("opening the doorbell: its descriptor was not found")
        return Doorbell(listener, new[0], signals)

    def _is_bell(self, descriptor):
        bell = socket.socket(fileno=os.dup(descriptor))
        with bell:
            name = bell.getsockname()
        return isinstance(name, str) and name.startswith(f"{self.domain.root}/")

    def bells(self):
        """The doorbells of the other services: a function that rings a role with an event."""
        services = [role for role in c.HEALTH if role != self.role]
        notifiers = {
            role: self._keep(self._bell(role).notifier_builder().create()) for role in services
        }

        def ring(role, event):
            if role in notifiers:
                try:
                    notifiers[role].notify_with_custom_event_id(iox2.EventId.new(event))
                except Exception:
                    pass  # A role without a listener is no error.

        return ring


def _sockets():
    """Descriptors of this process that are sockets."""
    found = set()
    for name in os.listdir("/proc/self/fd"):
        try:
            if os.readlink(f"/proc/self/fd/{name}").startswith("socket:"):
                found.add(int(name))
        except OSError:
            continue
    return found


class Doorbell:
    """How a process sleeps until there is a message for it."""

    def __init__(self, listener, descriptor, signals):
        self._listener, self._signals = listener, signals
        self._descriptors = (descriptor, signals.fileno())

    def wait(self, deadline_ns):
        """Sleeps until a ring, a signal or `deadline_ns`; the set of events that rang."""
        left_ns = min(max(0, deadline_ns - now_ns()), WAKE_AT_LEAST_NS)
        # `select` takes microseconds; `poll` rounds up to milliseconds.
        ready, _, _ = select.select(self._descriptors, (), (), left_ns * 1e-9)
        if self._signals.fileno() in ready:
            self._signals.recv(64)
        return {event.id.as_value for event in self._listener.try_wait()}
