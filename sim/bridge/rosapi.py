"""Services of rosapi: the topics, services and types of an exchange."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..competition.messages import seconds
from ..competition.transport import Values
from .client import Client
from .exchange import Exchange
from .messages import MESSAGES, MessageType, canonical

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
