"""Topics and services of the bridge, and of rosapi."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine, Iterable, Mapping
from dataclasses import field
from typing import Any

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion

from ..cell import CellCommand, CellTask, Rejected
from . import protocol
from .client import ADVERTISED, Client, Subscription
from .messages import (
    MESSAGES,
    MessageError,
    MessageType,
    UnknownTypeError,
    canonical,
    conform,
    message_type,
    seconds,
)
from .protocol import ProtocolError

MOST_TOPICS = 1000
"""Number of topics that all clients may create, and to which one may subscribe."""

MOST_CALLS = 100
"""Number of service calls of one client at the same time."""


class RefusedError(UserError):
    """Rejected request of a client, which gets the reason."""


Values = dict[str, Any]
"""Fields of a message, a request or an answer by name."""

Heard = Callable[[Values, str], None]
"""Takes a message and the name of the client that published it. It may raise `RefusedError`."""

Answer = Values | Coroutine[Any, Any, Values]
Serve = Callable[[Client, Values], Answer]
"""Answers a request of a client. It may raise `RefusedError`."""


def take(topic: str, port: CellCommand | CellTask, value: Any, source: str) -> Any:
    """Pass a value from a topic to a command or task of the cell, and return the running task.

    `RefusedError` names the topic and the value if it is rejected.
    """
    try:
        if isinstance(port, CellTask):
            return port.start(value, source)
        port.take(value, source)
    except Rejected as why:
        raise RefusedError(str(why.named(topic))) from None


@dataclass(eq=False)
class Topic:
    """Topic with the clients that publish on it and subscribe to it.

    The simulation publishes on topics that are `ours`. `heard` handles the messages of clients.
    """

    name: str
    type: MessageType
    ours: bool = False
    heard: Heard | None = None
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

    name: str
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
        self, name: str, type_: str, *, heard: Heard | None = None, latched: int = 0
    ) -> Topic:
        """Return a new topic of the simulation. With `heard`, clients may publish on it, too.

        The last `latched` messages are sent to each client that subscribes later.
        """
        return self._add(Topic(name, message_type(type_), True, heard, deque(maxlen=latched)))

    def listen(self, name: str, type_: str, heard: Heard) -> None:
        """Add a topic on which clients publish."""
        self._add(Topic(name, message_type(type_), heard=heard))

    def _add(self, topic: Topic) -> Topic:
        self.topics[topic.name] = topic
        self._own += 1
        return topic

    def provide(
        self, name: str, type_: str, answer: Serve, request: Mapping[str, str] | None = None
    ) -> None:
        """Add a service. `request` contains the types of its arguments by name."""
        self.services[name] = Service(
            name, MessageType(canonical(type_, "srv"), dict(request or {})), answer
        )

    def publish(self, topic: Topic, message: Values) -> None:
        """Send a message of the simulation to every subscriber of its topic."""
        if topic.is_needed:
            self._spread(topic, protocol.publication(topic.name, message))

    def take(self, client: Client, text: str | bytes) -> None:
        """Carry out an operation of a client, or send the client the fault."""
        id: str | int | None = None
        try:
            operation = protocol.decode(text)
            id = operation.id
            self._perform(client, operation)
        except ProtocolError as why:
            client.report("error", str(why), why.id if why.id is not None else id)
        except (MessageError, RefusedError, UnknownTypeError) as why:
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
        except (MessageError, RefusedError) as why:
            answer = str(why)
        if isinstance(answer, dict | str):
            self._respond(client, request, answer)
        elif len(client.calls) >= MOST_CALLS:
            answer.close()
            self._respond(client, request, f"{MOST_CALLS} calls are the maximum")
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
        return service.answer(client, conform(service.type, arguments))

    async def _await(
        self, client: Client, request: protocol.CallService, answer: Coroutine[Any, Any, Values]
    ) -> None:
        try:
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


_SINGLE = -1
"""Length of no array in rosapi_msgs/TypeDef. Arrays of any length have the length 0."""

_US = "/floorwalker"
"""Name of this node."""


def provide_rosapi(exchange: Exchange, now: Callable[[], float]) -> None:
    """Add the services of rosapi to an exchange. `now()` is the time (s)."""
    topics, services = exchange.topics, exchange.services

    def provide(
        name: str, type_: str, answer: Callable[..., Values], argument: str | None = None
    ) -> None:
        """Add a service with at most one argument, a string."""
        exchange.provide(
            f"/rosapi/{name}",
            f"rosapi_msgs/{type_}",
            lambda _, request: answer(**request),
            {argument: "string"} if argument else {},
        )

    def type_in(listed: dict[str, Any], name: str) -> Values:
        return {"type": listed[name].type.name if name in listed else ""}

    def of_type(listed: dict[str, Any], field: str, kind: str) -> Callable[[str], Values]:
        def names(type: str) -> Values:
            full = canonical(type, kind)
            return {field: sorted(n for n, one in listed.items() if one.type.name == full)}

        return names

    def all_topics() -> Values:
        names = sorted(topics)
        return {"topics": names, "types": [topics[name].type.name for name in names]}

    def publishers(topic: str) -> Values:
        one = topics.get(topic)
        return {"publishers": _nodes(one.ours, one.publishers) if one else []}

    def subscribers(topic: str) -> Values:
        one = topics.get(topic)
        return {"subscribers": _nodes(one.heard, one.subscriptions) if one else []}

    provide("topics", "Topics", all_topics)
    provide("topic_type", "TopicType", lambda topic: type_in(topics, topic), "topic")
    provide("topics_for_type", "TopicsForType", of_type(topics, "topics", "msg"), "type")
    provide("publishers", "Publishers", publishers, "topic")
    provide("subscribers", "Subscribers", subscribers, "topic")
    provide("services", "Services", lambda: {"services": sorted(services)})
    provide("service_type", "ServiceType", lambda service: type_in(services, service), "service")
    provide("services_for_type", "ServicesForType", of_type(services, "services", "srv"), "type")
    provide("message_details", "MessageDetails", _details, "type")
    provide("nodes", "Nodes", lambda: {"nodes": [_US]})
    provide("action_servers", "GetActionServers", lambda: {"action_servers": []})
    provide("get_param_names", "GetParamNames", lambda: {"names": []})
    provide("get_time", "GetTime", lambda: {"time": seconds(now())})


def _nodes(ours: object, clients: Iterable[Client]) -> list[str]:
    return [_US] * bool(ours) + sorted(client.name for client in clients)


def _details(type: str) -> Values:
    """Return the definitions of a type and all types in it."""
    names, defined = [canonical(type, "msg")], list[str]()
    for name in names:
        if name in MESSAGES and name not in defined:
            defined.append(name)
            fields = MESSAGES[name].fields.values()
            names += [kind.partition("[")[0] for kind in fields if "/" in kind]
    return {"typedefs": [_definition(MESSAGES[name]) for name in defined]}


def _definition(type_: MessageType) -> Values:
    types = type_.fields.values()
    return {
        "type": type_.name,
        "fieldnames": list(type_.fields),
        "fieldtypes": [kind.partition("[")[0] for kind in types],
        "fieldarraylen": [
            int(kind[:-1].partition("[")[2] or 0) if "[" in kind else _SINGLE for kind in types
        ],
        "examples": [],
        "constnames": [],
        "constvalues": [],
    }
