"""A ROS 2 node that forecasts the ball.

    python ros2_node.py --ros-args -p simulator:=amended.yaml

It subscribes to the measured position of the ball, in the table frame, and publishes its path over
the coming 300 ms and the next bounce. Stamps are those of the measurements. rallygap does not need
ROS; this file needs rclpy, and rallygap on the Python path.
"""

import numpy as np
import rclpy
from geometry_msgs.msg import PointStamped, PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.time import Time

from rallygap.models.ball.types import Floats
from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.io.simulators import load_simulator

AHEAD = 0.01 * np.arange(1, 31)  # s


class BallForecast(Node):
    """Forecasts after every measurement."""

    def __init__(self) -> None:
        super().__init__("ball_forecast")
        simulator = self.declare_parameter("simulator", "literature").value
        self.forecaster = Forecaster(load_simulator(simulator))
        self.path = self.create_publisher(Path, "ball/forecast", 1)
        self.bounce = self.create_publisher(PointStamped, "ball/bounce", 1)
        self.create_subscription(PointStamped, "ball/measured", self.measured, 10)

    def measured(self, message: PointStamped) -> None:
        """Take a measurement; publish the forecast."""
        t = Time.from_msg(message.header.stamp).nanoseconds / 1e9
        point = message.point
        self.forecaster.observe(t, [point.x, point.y, point.z])
        if not self.forecaster.ready:
            return
        times = self.forecaster.last + AHEAD
        states, _ = self.forecaster.predict(times)
        path = Path(header=message.header)
        path.poses = [self.pose(t, state, message) for t, state in zip(times, states, strict=True)]
        self.path.publish(path)
        event = self.forecaster.bounce()
        if event is not None:
            self.bounce.publish(self.point(event.time, event.state, message))

    def pose(self, t: float, state: Floats, message: PointStamped) -> PoseStamped:
        """Return the place of a state."""
        pose = PoseStamped()
        pose.header.frame_id = message.header.frame_id
        pose.header.stamp = Time(nanoseconds=round(t * 1e9)).to_msg()
        place = pose.pose.position
        place.x, place.y, place.z = state[:3].tolist()
        return pose

    def point(self, t: float, state: Floats, message: PointStamped) -> PointStamped:
        """Return the place of a bounce."""
        point = PointStamped()
        point.header.frame_id = message.header.frame_id
        point.header.stamp = Time(nanoseconds=round(t * 1e9)).to_msg()
        point.point.x, point.point.y, point.point.z = state[:3].tolist()
        return point


def main() -> None:
    """Run the node."""
    rclpy.init()
    rclpy.spin(BallForecast())


if __name__ == "__main__":
    main()
