"""The calls of services and the messages on topics that missions send."""

from dock_gateway.core.errors import NotFound, NotInstalled, fields_of_a_message, not_covered
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions.actions import covers_message
from dock_gateway.extensions.missions.step import SingleStep
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.ros.messages.codec import codec


class Messages:
    """Calls services and publishes messages, as the allow-lists of the settings let it.

    Args:
        services: Calls services.
        publishing: Publishes messages.
    """

    def __init__(self, services: ServiceCalls, publishing: Publishing) -> None:
        self._services = services
        self._publishing = publishing

    def require(self, step: SingleStep, grant: Grant) -> None:
        """Refuse a service or a topic that the settings or a grant do not include.

        Raises:
            NotAllowed: They do not (`not_allowed`), or it is used in another way (`use_other_request`).
        """
        if not covers_message(step, grant):
            raise not_covered("a service or a topic of the mission")
        if step.call is not None:
            self._services.listed.require(step.call.service)
        if step.publish is not None:
            self._publishing.require_allowed(step.publish.topic)

    async def check(self, step: SingleStep, place: str) -> None:
        """Check the request or message of a step, as far as its type can be known now.

        Args:
            step: The step.
            place: Where it is in a request, for errors.

        Raises:
            InvalidField: It is not one of this service or topic.
            Unavailable: `ros_unavailable`.
        """
        try:
            if step.call is not None:
                with fields_of_a_message(f"{place}.call"):
                    service = await self._services.find(step.call.service, step.call.type)
                kind = await self._services.load(service)
                await codec(kind.Request).read(step.call.request, f"{place}.call.request")
            elif step.publish is not None:
                with fields_of_a_message(f"{place}.publish"):
                    topic = await self._publishing.find(step.publish.topic, step.publish.type)
                await codec(await self._publishing.load(topic)).read(step.publish.message, f"{place}.publish.message")
        except (NotFound, NotInstalled):
            return  # it may come later

    async def send(self, step: SingleStep) -> None:
        """Call the service of a step, or publish its message.

        Raises:
            GatewayError: As `ServiceCalls.call` and `Publishing.publish`.
        """
        if step.call is not None:
            call, within = step.call, step.answer_within
            await self._services.call(call.service, call.request, type_name=call.type, timeout=within)
        elif step.publish is not None:
            await self._publishing.publish(step.publish.topic, step.publish.message, type_name=step.publish.type)
