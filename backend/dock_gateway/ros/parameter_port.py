"""Reads, describes and sets the parameters of a ROS node."""

from collections.abc import Iterable, Mapping

from rcl_interfaces.msg import Parameter, ParameterDescriptor, ParameterValue, SetParametersResult
from rcl_interfaces.srv import DescribeParameters, SetParameters, SetParametersAtomically

from dock_gateway.core.request import act
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.parameter_reader import ANSWER_WITHIN, ParameterReader
from dock_gateway.ros.service_client import ServiceClient

# A response to a client that is new may be lost; reading can be repeated.
ATTEMPTS = 3


class ParameterPort(ParameterReader):
    """The parameters of one node. `close` it after use.

    Args:
        bridge: The bridge to the ROS thread.
        node: Full name of the node.
        within: Seconds to find the node's services, and to wait until parameters are set.
    """

    def __init__(self, bridge: Bridge, node: str, within: float) -> None:
        super().__init__(bridge, node, within, ATTEMPTS)
        self._within = within
        self._describer = ServiceClient(bridge, DescribeParameters, f"{node}/describe_parameters", within)
        self._setter = ServiceClient(bridge, SetParameters, f"{node}/set_parameters", within)
        self._at_once = ServiceClient(bridge, SetParametersAtomically, f"{node}/set_parameters_atomically", within)

    async def describe(self, names: Iterable[str]) -> Mapping[str, ParameterDescriptor]:
        """Return the descriptors of parameters, by name; without those that the node does not describe.

        Raises:
            TimeoutError: The node does not answer.
            Unavailable: It is gone, or the ROS thread is down.
        """
        answer = await self._describer.call(
            DescribeParameters.Request(names=list(names)), ANSWER_WITHIN, attempts=ATTEMPTS
        )
        return {descriptor.name: descriptor for descriptor in answer.descriptors}

    async def set(self, values: Mapping[str, ParameterValue], *, at_once: bool) -> list[SetParametersResult]:
        """Set parameters, and return the results in their order; with `at_once` all or none, and one result.

        Raises:
            TimeoutError: The node does not answer. It may have set them.
            Unavailable: It is gone, or the ROS thread is down.
        """
        parameters = [Parameter(name=name, value=value) for name, value in values.items()]
        if at_once:
            request = SetParametersAtomically.Request(parameters=parameters)
            return [(await self._at_once.ask(request, self._within, act)).result]
        answer = await self._setter.ask(SetParameters.Request(parameters=parameters), self._within, act)
        return list(answer.results)

    def close(self) -> None:
        """Leave the graph."""
        super().close()
        for client in (self._describer, self._setter, self._at_once):
            client.close()
