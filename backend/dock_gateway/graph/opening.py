"""Opens what reads and uses the ROS graph."""

from contextlib import AsyncExitStack

from dock_gateway.core.tasks import closed_by
from dock_gateway.core.work import Work, in_turn
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.parameters import Parameters
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings


def open_graph(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the graph's names, the messages of any topic, services, parameters, and publishing for clients."""
    settings, bridge, interlock = parts[Settings], parts[Bridge], parts[Interlock]
    stack.push_async_callback(in_turn.close)
    graph = parts.add(GraphCache, closed_by(stack, GraphCache(bridge)))
    work = parts.add(Work, closed_by(stack, Work()))
    parts.add(Relays, closed_by(stack, Relays(bridge, graph, work)))
    publishing = parts.add(Publishing, closed_by(stack, Publishing(settings, bridge, interlock)))
    interlock.on_latch.append(publishing.withdraw)
    parts.add(ServiceCalls, closed_by(stack, ServiceCalls(settings, bridge, interlock)))
    parts.add(Parameters, closed_by(stack, Parameters(settings, bridge)))
