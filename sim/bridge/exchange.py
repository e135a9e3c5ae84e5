"""Topics and services, and what clients do with them: the part of a bridge without sockets."""

from __future__ import annotations

import asyncio
import inspect
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

from floorplan import suggestion

from .client import Client, Subscription, Wish
from .conformance import MessageError, conform
from .message_types import (
    SERVICES,
    MessageType,
    ServiceType,
    UnknownTypeError,
    canonical,
    message_type,
)
from .protocol import (
    LONGEST_MESSAGE,
    Advertise,
    CallService,
    Fragment,
    Operation,
    ProtocolError,
    Publish,
    SetLevel,
    Subscribe,
    Unadvertise,
    Unsubscribe,
    decode,
    encode,
    publication,
)

MOST_TOPICS = 1000
"""How many topics clients may bring into being altogether, and one client may subscribe to."""

MOST_CALLS = 100
"""How many service calls of one client may be under way at once."""


class RefusedError(ValueError):
    """Something that a client asked for and doesn't get; it is told why."""


Heard = Callable[[Client, dict[str, Any]], None]
"""Is told of a message that a client published; may raise `RefusedError`."""

Answer = dict[str, Any]
Serve = Callable[[Client, dict[str, Any]], "Answer | Awaitable[Answer]"]
"""Answers a request of a client; may raise `RefusedError`."""


class Topic:
    """A topic: `heard` is told of what clients publish on it; without it, only we publish."""

    def __init__(
        self, name: str, type_: MessageType, *, ours: bool, heard: Heard | None, latched: int
    ) -> None:
        self.name = name
        self.type = type_
        self.ours = ours
        self.heard = heard
        self.latched = latched
        self.kept: deque[str] = deque(maxlen=latched)
        self.subscriptions: dict[Client, Subscription] = {}
        self.publishers: set[Client] = set()

    @property
    def is_needed(self) -> bool:
        """Whether anybody hears or ever will hear what is published now."""
        return bool(self.latched or self.subscriptions)


class Service:
    """A service, and who answers."""

    def __init__(self, name: str, type_: ServiceType, answer: Serve) -> None:
        self.name = name
        self.type = type_
        self.answer = answer


class Exchange:
    """Everything there is to publish, to hear and to ask, and what each client has to do with it.

    `changed(client)` is called whenever a client advertises, publishes, subscribes or takes that
    back.
    """

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.services: dict[str, Service] = {}
        self.changed: Callable[[Client], None] = lambda _: None
        self._brought: set[str] = set()

    # What there is to hear and to ask.

    def advertise(
        self, name: str, type_: str, *, heard: Heard | None = None, latched: int = 0
    ) -> Topic:
        """A topic that we publish on, and with `heard` clients as well.

        Its last `latched` messages are sent to everybody who subscribes later.
        """
        topic = Topic(name, message_type(type_), ours=True, heard=heard, latched=latched)
        self.topics[name] = topic
        return topic

    def listen(self, name: str, type_: str, heard: Heard) -> Topic:
        """A topic that clients publish on."""
        topic = Topic(name, message_type(type_), ours=False, heard=heard, latched=0)
        self.topics[name] = topic
        return topic

    def provide(self, name: str, type_: str, answer: Serve) -> None:
        """A service."""
        self.services[name] = Service(name, SERVICES[canonical(type_, "srv")], answer)

    def publish(self, topic: Topic, message: dict[str, Any]) -> None:
        """Send a message of ours to everybody who subscribed to its topic."""
        if topic.is_needed:
            self._spread(topic, publication(topic.name, message))

    # What clients say.

    def take(self, client: Client, text: str | bytes) -> None:
        """A client has sent something: do it, or tell the client what is wrong with it."""
        id: str | int | None = None
        try:
            operation = decode(text)
            id = operation.id
            self._perform(client, operation)
        except ProtocolError as why:
            client.tell("error", str(why), why.id if why.id is not None else id)
        except (MessageError, RefusedError, UnknownTypeError) as why:
            client.tell("error", str(why), id)

    def forget(self, client: Client) -> None:
        """A client has gone."""
        for call in client.calls:
            call.cancel()
        for name in list(client.subscriptions):
            self._unsubscribe(client, name, None)
        for name in list(client.advertised):
            self._withdraw(client, name)

    def _perform(self, client: Client, operation: Operation) -> None:
        if isinstance(operation, Publish):
            self._hear(client, operation)
        elif isinstance(operation, CallService):
            self._call(client, operation)
        elif isinstance(operation, Subscribe):
            self._subscribe(client, operation)
        elif isinstance(operation, Advertise):
            self._advertise(client, operation)
        elif isinstance(operation, Unsubscribe):
            name = _absolute(operation.topic)
            if not self._unsubscribe(client, name, operation.id):
                client.tell("warning", f"not subscribed to {name}", operation.id)
        elif isinstance(operation, Unadvertise):
            name = _absolute(operation.topic)
            if name not in client.advertised:
                client.tell("warning", f"{name} was not advertised", operation.id)
            self._withdraw(client, name)
        elif isinstance(operation, SetLevel):
            client.level = operation.level
        elif isinstance(operation, Fragment):
            whole = client.reassembly.add(operation)
            if whole is not None:
                inner = decode(whole)
                if isinstance(inner, Fragment):
                    raise ProtocolError("a fragment of fragments", operation.id)
                self._perform(client, inner)

    def _advertise(self, client: Client, request: Advertise) -> None:
        name, type_ = _absolute(request.topic), message_type(request.type)
        topic = self.topics.get(name)
        if topic is None:
            topic = self._bring_forth(name, type_)
        self._require_type(topic, type_)
        self._require_open(topic)
        topic.publishers.add(client)
        client.advertise(topic.name)
        self.changed(client)

    def _hear(self, client: Client, publish: Publish) -> None:
        name = _absolute(publish.topic)
        topic = self.topics.get(name)
        if topic is None:
            near = suggestion(name, self._open_topics())
            raise RefusedError(f"no topic is called {name!r}; advertise it first ({near})")
        self._require_open(topic)
        message = conform(topic.type, publish.msg)
        text = publication(topic.name, message)
        if len(text) > LONGEST_MESSAGE:
            raise RefusedError(
                f"a message of {len(text)} characters once it is complete;"
                f" {LONGEST_MESSAGE} is the most that is passed on"
            )
        if client not in topic.publishers:
            topic.publishers.add(client)
            client.advertise(topic.name)
            self.changed(client)
        if topic.heard is not None:
            topic.heard(client, message)
        self._spread(topic, text)

    def _subscribe(self, client: Client, request: Subscribe) -> None:
        if request.compression not in (None, "none"):
            raise RefusedError(f"no compression {request.compression!r}; there is: none")
        name = _absolute(request.topic)
        topic = self.topics.get(name)
        if topic is None:
            if request.type is None:
                raise RefusedError(f"no topic is called {name!r}; give its type to wait for it")
            topic = self._bring_forth(name, message_type(request.type))
        elif request.type is not None:
            self._require_type(topic, message_type(request.type))
        subscription = client.subscriptions.get(name)
        if subscription is None:
            if len(client.subscriptions) >= MOST_TOPICS:
                raise RefusedError(f"{MOST_TOPICS} subscriptions are the most")
            subscription = Subscription(topic.name, client)
            client.subscriptions[topic.name] = topic.subscriptions[client] = subscription
        if subscription.wishes >= MOST_TOPICS:
            raise RefusedError(f"{MOST_TOPICS} subscriptions are the most")
        subscription.add(request.id, Wish.of(request))
        for text in topic.kept:
            subscription.offer(text)
        self.changed(client)

    def _unsubscribe(self, client: Client, name: str, id: str | int | None) -> bool:
        subscription = client.subscriptions.get(name)
        if subscription is None:
            return False
        found = subscription.remove(id)
        if not subscription.wishes:
            del client.subscriptions[name]
            topic = self.topics[name]
            del topic.subscriptions[client]
            self._let_fade(topic)
            self.changed(client)
        return found

    def _withdraw(self, client: Client, name: str) -> None:
        client.withdraw(name)
        topic = self.topics.get(name)
        if topic is not None:
            topic.publishers.discard(client)
            self._let_fade(topic)
            self.changed(client)

    def _bring_forth(self, name: str, type_: MessageType) -> Topic:
        """A topic of the clients' own: what one publishes, the others hear."""
        if len(self._brought) >= MOST_TOPICS:
            raise RefusedError(f"{MOST_TOPICS} topics are the most that clients may bring")
        topic = Topic(name, type_, ours=False, heard=None, latched=0)
        self.topics[name] = topic
        self._brought.add(name)
        return topic

    def _let_fade(self, topic: Topic) -> None:
        if topic.name in self._brought and not topic.subscriptions and not topic.publishers:
            self._brought.remove(topic.name)
            del self.topics[topic.name]

    def _open_topics(self) -> list[str]:
        return [t.name for t in self.topics.values() if t.heard is not None or not t.ours]

    def _require_type(self, topic: Topic, type_: MessageType) -> None:
        if topic.type is not type_:
            raise RefusedError(f"{topic.name} is of type {topic.type.name}, not {type_.name}")

    def _require_open(self, topic: Topic) -> None:
        if topic.ours and topic.heard is None:
            raise RefusedError(f"{topic.name} is published by the simulation alone")

    def _spread(self, topic: Topic, text: str) -> None:
        topic.kept.append(text)
        for subscription in tuple(topic.subscriptions.values()):
            subscription.offer(text)

    # Services.

    def _call(self, client: Client, request: CallService) -> None:
        name = _absolute(request.service)
        service = self.services.get(name)
        try:
            if service is None:
                raise RefusedError(
                    f"no service is called {name!r}; {suggestion(name, self.services)}"
                )
            arguments = conform(service.type.request, _arguments(service, request.args))
            answer = service.answer(client, arguments)
        except (MessageError, RefusedError) as why:
            self._respond(client, request, str(why), result=False)
            return
        if not inspect.isawaitable(answer):
            self._respond(client, request, answer, result=True)
            return
        if len(client.calls) >= MOST_CALLS:
            _discard(answer)
            self._respond(client, request, f"{MOST_CALLS} calls are the most", result=False)
            return
        client.begin_call(asyncio.ensure_future(self._await(client, request, answer)))

    async def _await(self, client: Client, request: CallService, answer: Awaitable[Answer]) -> None:
        try:
            self._respond(client, request, await answer, result=True)
        except RefusedError as why:
            self._respond(client, request, str(why), result=False)

    def _respond(
        self, client: Client, request: CallService, values: Answer | str, *, result: bool
    ) -> None:
        response: dict[str, Any] = {
            "op": "service_response",
            "service": request.service,
            "values": values,
            "result": result,
        }
        if request.id is not None:
            response["id"] = request.id
        client.answer(encode(response), request.fragment_size)


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


def _arguments(service: Service, given: dict[str, Any] | list[Any] | None) -> dict[str, Any]:
    """The arguments by name: clients may give them in their order instead."""
    if not isinstance(given, list):
        return given or {}
    names = [field.name for field in service.type.request.fields]
    if len(given) > len(names):
        raise RefusedError(f"{service.name} takes {len(names)} arguments, not {len(given)}")
    return dict(zip(names, given, strict=False))


def _discard(answer: Awaitable[Answer]) -> None:
    """Close a coroutine that nobody will wait for."""
    if inspect.iscoroutine(answer):
        answer.close()
