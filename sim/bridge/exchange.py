"""Topics and services of the bridge, and the operations of clients on them."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from typing import Any

from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion

from ..cell import Rejected
from ..competition.transport import Heard, Read, RefusedError, Values
from . import protocol
from .client import ADVERTISED, Client, Subscription
from .messages import MessageError, MessageType, canonical, conform, message_type
from .protocol import ProtocolError

MOST_TOPICS = 1000
"""Number of topics that all clients may create, and to which one may subscribe."""

Answer = Values | Coroutine[Any, Any, Values]
Serve = Callable[[Client, Values], Answer]
"""Answers a request of a client. It may raise `RefusedError`."""


@dataclass(eq=False)
class Topic:
    """Topic with the clients that publish on it and subscribe to it.

    The simulation publishes on topics that are `ours`, and `read` returns the present message.
    `heard` handles the messages of clients.
    """

    name: str
    type: MessageType
    ours: bool = False
    heard: Heard | None = None
    read: Read | None = None
    kept: deque[str] = field(default_factory=lambda: deque(maxlen=0))
    subscriptions: dict[Client, Subscription] = field(default_factory=dict)
    publishers: set[Client] = field(default_factory=set)

    @property
    def is_needed(self) -> bool:
        """Whether a message that is published now reaches a client, now or later."""
        return bool(self.kept.maxlen or self.subscriptions)

    @property
    def is_open(self) -> bool:
        """Whether clients may publish on it."""
        return self.heard is not None or not self.ours

    @property
    def is_of_clients(self) -> bool:
        """Whether a client created the topic for other clients."""
        return not self.ours and self.heard is None


@dataclass(frozen=True)
class Service:
    """Service with the type of its requests, and the function that answers them."""

    type: MessageType
    answer: Serve


class Exchange:
    """All topics and services, and the operations of clients on them.

    `changed()` is called whenever a client begins or ends to advertise, publish or subscribe.
    """

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.services: dict[str, Service] = {}
        self.changed: Callable[[], None] = lambda: None
        self._own = 0

    def advertise(
        self,
        name: str,
        type_: str,
        read: Read | None = None,
        *,
        heard: Heard | None = None,
        latched: int = 0,
    ) -> Topic:
        """Return a new topic of the simulation. With `heard`, clients may publish on it, too.

        `publish_state` publishes what `read` returns. The last `latched` messages are sent to each
        client that subscribes later.
        """
        self._own += 1
        kept: deque[str] = deque(maxlen=latched)
        topic = self.topics[name] = Topic(name, message_type(type_), True, heard, read, kept)
        return topic

    def listen(self, name: str, type_: str, heard: Heard) -> None:
        """Add a topic on which clients publish."""
        self._own += 1
        self.topics[name] = Topic(name, message_type(type_), heard=heard)

    def provide(
        self, name: str, type_: str, answer: Serve, request: Mapping[str, str] | None = None
    ) -> None:
        """Add a service. `request` contains the types of its arguments by name."""
        type_ = canonical(type_, "srv")
        self.services[name] = Service(MessageType(type_, dict(request or {})), answer)

    def publish(self, topic: Topic, message: Values) -> None:
        """Send a message of the simulation to every subscriber of its topic."""
        if topic.kept.maxlen:  # such messages are rare, and may omit fields
            message = conform(topic.type, message)
        if topic.is_needed:
            self._spread(topic, protocol.publication(topic.name, message))

    def publish_state(self) -> None:
        """Publish the present message of each topic that has one."""
        for topic in tuple(self.topics.values()):
            if topic.read is not None and topic.is_needed and (message := topic.read()) is not None:
                self.publish(topic, message)

    def take(self, client: Client, text: str | bytes) -> None:
        """Carry out an operation of a client, or send the client the fault."""
        id: str | int | None = None
        try:
            operation = protocol.decode(text)
            id = operation.id
            self._perform(client, operation)
        except ProtocolError as why:
            client.report("error", str(why), id if why.id is None else why.id)
        except RefusedError as why:
            client.report("error", str(why), id)

    def forget(self, client: Client) -> None:
        """End all calls, subscriptions and announcements of a client that has gone."""
        for call in client.calls:
            call.cancel()
        for name in list(client.subscriptions):
            self._unsubscribe(client, name, None)
        for name in list(client.advertised):
            self._withdraw(client, name)

    def _perform(self, client: Client, operation: protocol.Operation) -> None:
        if isinstance(operation, protocol.Publish):
            self._hear(client, operation)
        elif isinstance(operation, protocol.CallService):
            self._call(client, operation)
        elif isinstance(operation, protocol.Subscribe):
            self._subscribe(client, operation)
        elif isinstance(operation, protocol.Advertise):
            self._advertise(client, operation)
        elif isinstance(operation, protocol.Unsubscribe):
            if not self._unsubscribe(client, operation.topic, operation.id):
                client.report("warning", f"not subscribed to {operation.topic}", operation.id)
        elif isinstance(operation, protocol.Unadvertise):
            if not self._withdraw(client, operation.topic):
                client.report("warning", f"{operation.topic} was not advertised", operation.id)
        elif isinstance(operation, protocol.SetLevel):
            client.level = operation.level
        elif isinstance(operation, protocol.Fragment):
            whole = client.reassembly.add(operation)
            if whole is not None:
                inner = protocol.decode(whole)
                if isinstance(inner, protocol.Fragment):
                    raise ProtocolError("nested fragments are not allowed", operation.id)
                self._perform(client, inner)

    def _advertise(self, client: Client, request: protocol.Advertise) -> None:
        type_ = message_type(request.type)
        topic = self.topics.get(request.topic) or self._create(request.topic, type_)
        self._require_type(topic, type_)
        self._require_open(topic)
        self._add_publisher(topic, client)

    def _hear(self, client: Client, publish: protocol.Publish) -> None:
        topic = self.topics.get(publish.topic)
        if topic is None:
            near = suggestion(publish.topic, [t.name for t in self.topics.values() if t.is_open])
            raise RefusedError(f"no topic is called {publish.topic!r}; advertise it first ({near})")
        self._require_open(topic)
        try:
            message = conform(topic.type, publish.msg)
        except MessageError as why:
            raise MessageError(f"{topic.name}: {why}") from None
        text = protocol.publication(topic.name, message)
        if len(text) > protocol.LONGEST_MESSAGE:
            raise RefusedError(
                f"a message of {len(text)} characters once it is complete;"
                f" {protocol.LONGEST_MESSAGE} is the maximum"
            )
        self._add_publisher(topic, client)
        if topic.heard is not None:
            with _rejecting(topic.name):
                topic.heard(message, client.name)
        self._spread(topic, text)

    def _subscribe(self, client: Client, request: protocol.Subscribe) -> None:
        if request.compression not in (None, "none"):
            raise RefusedError(f"no compression {request.compression!r}; there is: none")
        name, topic = request.topic, self.topics.get(request.topic)
        subscription = client.subscriptions.get(name)
        others = client.subscriptions if subscription is None else subscription.requests
        if len(others) >= MOST_TOPICS:
            raise RefusedError(f"{MOST_TOPICS} subscriptions are the maximum")
        if topic is None:
            if request.type is None:
                raise RefusedError(f"no topic is called {name!r}; give its type to wait for it")
            topic = self._create(name, message_type(request.type))
        elif request.type is not None:
            self._require_type(topic, message_type(request.type))
        if subscription is None:
            subscription = Subscription(client)
            client.subscriptions[name] = topic.subscriptions[client] = subscription
        subscription.add(request)
        for text in topic.kept:
            subscription.offer(text)
        self.changed()

    def _unsubscribe(self, client: Client, name: str, id: str | int | None) -> bool:
        subscription = client.subscriptions.get(name)
        if subscription is None:
            return False
        is_removed = subscription.remove(id)
        if not subscription.requests:
            del client.subscriptions[name]
            topic = self.topics[name]
            del topic.subscriptions[client]
            self._drop_if_unused(topic)
        return is_removed

    def _withdraw(self, client: Client, name: str) -> bool:
        if name not in client.advertised:
            return False
        client.advertised.remove(name)
        client.account.add(-ADVERTISED)
        topic = self.topics[name]
        topic.publishers.remove(client)
        self._drop_if_unused(topic)
        return True

    def _create(self, name: str, type_: MessageType) -> Topic:
        """Return a new topic, on which clients hear each other."""
        if len(self.topics) - self._own >= MOST_TOPICS:
            raise RefusedError(f"{MOST_TOPICS} topics of clients are the maximum")
        topic = self.topics[name] = Topic(name, type_)
        return topic

    def _add_publisher(self, topic: Topic, client: Client) -> None:
        if client not in topic.publishers:
            topic.publishers.add(client)
            client.advertised.add(topic.name)
            client.account.add(ADVERTISED)
            self.changed()

    def _drop_if_unused(self, topic: Topic) -> None:
        if topic.is_of_clients and not topic.subscriptions and not topic.publishers:
            del self.topics[topic.name]
        self.changed()

    def _require_type(self, topic: Topic, type_: MessageType) -> None:
        if topic.type is not type_:
            raise RefusedError(f"{topic.name} is of type {topic.type.name}, not {type_.name}")

    def _require_open(self, topic: Topic) -> None:
        if not topic.is_open:
            raise RefusedError(f"{topic.name} is published by the simulation alone")

    def _spread(self, topic: Topic, text: str) -> None:
        topic.kept.append(text)
        for subscription in tuple(topic.subscriptions.values()):
            subscription.offer(text)

    def _call(self, client: Client, request: protocol.CallService) -> None:
        answer: Answer | str
        try:
            answer = self._answer(client, request)
        except RefusedError as why:
            answer = str(why)
        if isinstance(answer, dict | str):
            self._respond(client, request, answer)
        else:
            client.begin_call(asyncio.ensure_future(self._await(client, request, answer)))

    def _answer(self, client: Client, request: protocol.CallService) -> Answer:
        name = protocol.absolute(request.service)
        service = self.services.get(name)
        if service is None:
            raise RefusedError(f"no service is called {name!r}; {suggestion(name, self.services)}")
        arguments, fields = request.args or {}, service.type.fields
        if isinstance(arguments, list):  # in their order
            if len(arguments) > len(fields):
                raise RefusedError(f"{name} takes {len(fields)} arguments, not {len(arguments)}")
            arguments = dict(zip(fields, arguments, strict=False))
        with _rejecting(name):
            return service.answer(client, conform(service.type, arguments))

    async def _await(
        self, client: Client, request: protocol.CallService, answer: Coroutine[Any, Any, Values]
    ) -> None:
        try:
            with _rejecting(request.service):
                self._respond(client, request, await answer)
        except RefusedError as why:
            self._respond(client, request, str(why))

    def _respond(self, client: Client, request: protocol.CallService, values: Values | str) -> None:
        """Send the values of an answer, or the reason of a failure."""
        response: Values = {
            "op": "service_response",
            "service": request.service,
            "values": values,
            "result": not isinstance(values, str),
        }
        if request.id is not None:
            response["id"] = request.id
        client.outbox.reply(protocol.encode(response), request.fragment_size)


@contextmanager
def _rejecting(name: str) -> Iterator[None]:
    """Report a value that the cell rejects with the name of the topic or service."""
    try:
        yield
    except Rejected as why:
        raise RefusedError(str(why.named(name))) from None
