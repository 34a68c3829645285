"""DDS participants: each context is one."""

from collections.abc import Sequence

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier

from robot_io.rclpy_private import require_supported


def create_context(args: Sequence[str] | None = None, *, domain_id: int | None = None) -> Context:
    """Return a new ROS context without signal handlers of its own.

    Args:
        args: The command line with its `--ros-args`; None is that of the process.
        domain_id: None is the ROS_DOMAIN_ID of the environment.

    Raises:
        UnsupportedRclpyError: This rclpy lacks what we need.
        RCLError: ROS does not start.
        UnknownROSArgsError, RCLInvalidROSArgsError: The ROS arguments are wrong.
    """
    require_supported()
    context = Context()
    rclpy.init(
        args=None if args is None else list(args),
        context=context,
        domain_id=domain_id,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    return context


def middleware() -> str:
    """Return the name of the RMW implementation that is loaded, such as `rmw_fastrtps_cpp`."""
    return str(get_rmw_implementation_identifier())


class SecondParticipant:
    """A second DDS participant next to that of a node, for what one alone cannot have: a topic with two types.

    Attributes:
        node: A node on it, which only publishes.
    """

    def __init__(self, node: Node, name: str) -> None:
        """Join the graph.

        Args:
            node: The node whose domain and namespace are used.
            name: Name of the node.
        """
        self._context = create_context([], domain_id=node.context.get_domain_id())
        self.node = Node(
            name,
            namespace=node.get_namespace(),
            context=self._context,
            enable_rosout=False,
            start_parameter_services=False,
            use_global_arguments=False,
        )

    def close(self) -> None:
        """Leave the graph."""
        self.node.destroy_node()
        self._context.try_shutdown()
