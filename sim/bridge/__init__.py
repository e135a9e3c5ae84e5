"""The ROS bridge: a trial served over the rosbridge protocol, or an agent of another server.

`protocol` and `messages` define operations and types. `exchange` carries operations out. `server`
receives them over websockets, and `uplink` through another server. `workcell` provides the topics
and services of a simulation: those of `sim.competition`, and `body_topics`. `session` advances it.
`remote_agent` runs the agent of a person at another server.
"""

from ..competition import driven_person
from ..live.page_server import OriginError, Origins
from .exchange import Exchange
from .remote_agent import RemoteAgent
from .server import AddressError, RosbridgeServer, listen_at
from .session import Session
from .uplink import ConnectError
from .workcell import BridgeError, Workcell

__all__ = [
    "AddressError",
    "BridgeError",
    "ConnectError",
    "Exchange",
    "OriginError",
    "Origins",
    "RemoteAgent",
    "RosbridgeServer",
    "Session",
    "Workcell",
    "driven_person",
    "listen_at",
]
