"""Messages of the robot's sensors."""

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Range

from docking.core.geometry import Pose
from docking.ros.geometry import pose_message


def stamp(seconds: float) -> Time:
    return Time(sec=int(seconds), nanosec=round((seconds - int(seconds)) * 1e9))


def odometry(pose: Pose, at: float, *, frame: str = "odom", child: str = "base_link", speed: float = 0.0) -> Odometry:
    message = Odometry(child_frame_id=child)
    message.header.frame_id = frame
    message.header.stamp = stamp(at)
    message.pose.pose = pose_message(pose)
    message.twist.twist.linear.x = speed
    return message


def detection(pose: Pose, at: float, frame: str = "base_link") -> PoseStamped:
    message = PoseStamped(pose=pose_message(pose))
    message.header.frame_id = frame
    message.header.stamp = stamp(at)
    return message


def infrared(measured: float, *, least: float = 0.02, most: float = 1.5) -> Range:
    return Range(radiation_type=Range.INFRARED, field_of_view=0.5, min_range=least, max_range=most, range=measured)
