"""The ROS bridge: a trial served over the rosbridge protocol, or an agent at another one's.

From below: `protocol` and `messages` define what may be sent, `exchange` carries it out, and
`server` brings it in over websockets. `workcell` makes topics and services of a simulation and
`session` keeps its time. At the other end, `connection` is a client and `remote_agent` the body
of an agent.
"""

from ..live.page_server import OriginError, Origins
from .connection import ConnectError, RosbridgeConnection, ServiceError
from .exchange import Exchange
from .remote_agent import RemoteAgent
from .server import AddressError, RosbridgeServer, listen_at
from .session import Session
from .workcell import BridgeError, Workcell, driven_person

__all__ = [
    "AddressError",
    "BridgeError",
    "ConnectError",
    "Exchange",
    "OriginError",
    "Origins",
    "RemoteAgent",
    "RosbridgeConnection",
    "RosbridgeServer",
    "ServiceError",
    "Session",
    "Workcell",
    "driven_person",
    "listen_at",
]
