"""The services of rosapi, with which clients find out what there is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .client import Client
from .exchange import Answer, Exchange, Topic
from .message_types import MESSAGES, MessageType, UnknownTypeError, canonical, message_type
from .readings import seconds

_ARRAY, _SINGLE = 0, -1
"""Lengths in rosapi_msgs/TypeDef: an array of any length, no array."""


def provide_rosapi(exchange: Exchange, now: Callable[[], float]) -> None:
    """Let clients ask `exchange` for its topics, services and types; `now()` is the time (s)."""
    topics, services = exchange.topics, exchange.services

    def provide(name: str, type_: str, answer: Callable[[dict[str, Any]], Answer]) -> None:
        def serve(_: Client, request: dict[str, Any]) -> Answer:
            return answer(request)

        exchange.provide(f"/rosapi/{name}", f"rosapi_msgs/{type_}", serve)

    def topics_and_types(_: dict[str, Any]) -> Answer:
        names = sorted(topics)
        return {"topics": names, "types": [topics[name].type.name for name in names]}

    def topic_type(request: dict[str, Any]) -> Answer:
        topic = topics.get(request["topic"])
        return {"type": topic.type.name if topic else ""}

    def topics_for_type(request: dict[str, Any]) -> Answer:
        wanted = canonical(request["type"], "msg")
        return {"topics": sorted(n for n, topic in topics.items() if topic.type.name == wanted)}

    def service_type(request: dict[str, Any]) -> Answer:
        service = services.get(request["service"])
        return {"type": service.type.name if service else ""}

    def services_for_type(request: dict[str, Any]) -> Answer:
        wanted = canonical(request["type"], "srv")
        return {"services": sorted(n for n, one in services.items() if one.type.name == wanted)}

    def publishers(request: dict[str, Any]) -> Answer:
        topic = topics.get(request["topic"])
        ours = ["/floorwalker"] if topic and topic.ours else []
        return {"publishers": ours + _names(topic, "publishers")}

    def subscribers(request: dict[str, Any]) -> Answer:
        topic = topics.get(request["topic"])
        ours = ["/floorwalker"] if topic and topic.heard is not None else []
        return {"subscribers": ours + _names(topic, "subscriptions")}

    provide("topics", "Topics", topics_and_types)
    provide("topic_type", "TopicType", topic_type)
    provide("topics_for_type", "TopicsForType", topics_for_type)
    provide("publishers", "Publishers", publishers)
    provide("subscribers", "Subscribers", subscribers)
    provide("services", "Services", lambda _: {"services": sorted(services)})
    provide("service_type", "ServiceType", service_type)
    provide("services_for_type", "ServicesForType", services_for_type)
    provide("message_details", "MessageDetails", lambda request: _details(request["type"]))
    provide("nodes", "Nodes", lambda _: {"nodes": ["/floorwalker"]})
    provide("action_servers", "GetActionServers", lambda _: {"action_servers": []})
    provide("get_param_names", "GetParamNames", lambda _: {"names": []})
    provide("get_time", "GetTime", lambda _: {"time": seconds(now())})


def _names(topic: Topic | None, role: str) -> list[str]:
    return sorted(client.name for client in getattr(topic, role)) if topic else []


def _details(name: str) -> Answer:
    """The type and all types within it, each once."""
    try:
        wanted = [message_type(name)]
    except UnknownTypeError:
        return {"typedefs": []}
    found: dict[str, MessageType] = {}
    while wanted:
        type_ = wanted.pop(0)
        found.setdefault(type_.name, type_)
        inner = (MESSAGES[field.type] for field in type_.fields if "/" in field.type)
        wanted += [one for one in inner if one.name not in found]
    return {"typedefs": [_definition(type_) for type_ in found.values()]}


def _definition(type_: MessageType) -> dict[str, Any]:
    return {
        "type": type_.name,
        "fieldnames": [field.name for field in type_.fields],
        "fieldtypes": [field.type for field in type_.fields],
        "fieldarraylen": [_ARRAY if field.is_array else _SINGLE for field in type_.fields],
        "examples": [],
        "constnames": [],
        "constvalues": [],
    }
