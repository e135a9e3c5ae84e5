"""The ROS bridge: a trial served over the rosbridge protocol, or an agent at somebody else's.

From below: `protocol` and `conformance` say what may be sent, `exchange` what is done with it,
`server` brings it in over websockets. `workcell` makes topics and services of a simulation and
`session` keeps its time. At the other end, `connection` is a client and `remote_person` the body
of an agent there.
"""

from .connection import ConnectError, Connection, ServiceError
from .exchange import Exchange
from .origins import OriginError, Origins
from .remote_agent import RemoteAgent
from .server import AddressError, RosbridgeServer, listen_at
from .session import Session
from .workcell import BridgeError, Workcell, driven_person

__all__ = [
    "AddressError",
    "BridgeError",
    "ConnectError",
    "Connection",
    "Exchange",
    "OriginError",
    "Origins",
    "RemoteAgent",
    "RosbridgeServer",
    "ServiceError",
    "Session",
    "Workcell",
    "driven_person",
    "listen_at",
]
