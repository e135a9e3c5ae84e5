"""The services of rosapi, which list topics, services and types."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from .client import Client
from .exchange import Exchange, Values
from .message_types import MESSAGES, MessageType, canonical
from .readings import seconds

_ARRAY, _SINGLE = 0, -1
"""Lengths in rosapi_msgs/TypeDef: an array of any length, no array."""

_US = "/floorwalker"
"""The name of this node."""


def provide_rosapi(exchange: Exchange, now: Callable[[], float]) -> None:
    """Let clients ask `exchange` for its topics, services and types; `now()` is the time (s)."""
    topics, services = exchange.topics, exchange.services

    def provide(
        name: str, type_: str, answer: Callable[..., Values], argument: str | None = None
    ) -> None:
        """Add a service that has one string, or nothing, for its argument."""
        exchange.provide(
            f"/rosapi/{name}",
            f"rosapi_msgs/{type_}",
            lambda _, request: answer(**request),
            {argument: "string"} if argument else {},
        )

    def type_in(found: dict[str, Any], name: str) -> Values:
        return {"type": found[name].type.name if name in found else ""}

    def of_type(found: dict[str, Any], field: str, kind: str) -> Callable[[str], Values]:
        def list_them(type: str) -> Values:
            wanted = canonical(type, kind)
            return {field: sorted(n for n, one in found.items() if one.type.name == wanted)}

        return list_them

    def all_topics() -> Values:
        names = sorted(topics)
        return {"topics": names, "types": [topics[name].type.name for name in names]}

    def publishers(topic: str) -> Values:
        found = topics.get(topic)
        return {"publishers": _nodes(found.ours, found.publishers) if found else []}

    def subscribers(topic: str) -> Values:
        found = topics.get(topic)
        return {"subscribers": _nodes(found.heard, found.subscriptions) if found else []}

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
    """The type and all types within it, each once."""
    wanted, found = [canonical(type, "msg")], list[str]()
    for name in wanted:
        if name in MESSAGES and name not in found:
            found.append(name)
            fields = MESSAGES[name].fields.values()
            wanted += [kind.removesuffix("[]") for kind in fields if "/" in kind]
    return {"typedefs": [_definition(MESSAGES[name]) for name in found]}


def _definition(type_: MessageType) -> Values:
    types = type_.fields.values()
    return {
        "type": type_.name,
        "fieldnames": list(type_.fields),
        "fieldtypes": [kind.removesuffix("[]") for kind in types],
        "fieldarraylen": [_ARRAY if kind.endswith("[]") else _SINGLE for kind in types],
        "examples": [],
        "constnames": [],
        "constvalues": [],
    }
