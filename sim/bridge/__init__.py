"""The ROS bridge: a trial served over the rosbridge protocol, or an agent of another server.

`protocol` and `messages` define operations and types. `exchange` carries operations out. `server`
receives them over websockets, and `uplink` through another server. `workcell` provides the topics
and services of a simulation: those of `sim.competition`, and `floor_topics`. `session` advances it.
`connection` is a client, and `remote_agent` the body of an agent that uses it.
"""

from ..competition import driven_person
from ..live.page_server import OriginError, Origins
from .connection import ConnectError, RosbridgeConnection, ServiceError
from .exchange import Exchange
from .remote_agent import RemoteAgent
from .server import AddressError, RosbridgeServer, listen_at
from .session import Session
from .workcell import BridgeError, Workcell

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
