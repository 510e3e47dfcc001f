"""A detector of scanbench that asks a ROS 2 node.

It publishes the scan as PointCloud2, waits for the answer with the same stamp, and returns it.

Untested: neither CI nor we have run it, for lack of ROS 2. In a shell where ROS 2 is sourced, the command of the detector is
["python3", "-m", "scanbench.serve", "ros_bridge.py:Bridge"].
"""

import numpy as np
import rclpy
from sensor_msgs.msg import PointCloud2, PointField
from vision_msgs.msg import Detection3DArray

import scanbench

FIELDS = [
    PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
    for i, name in enumerate(["x", "y", "z", "intensity"])
]


@scanbench.detector(name="my-node")
class Bridge:
    def __init__(self, points_topic: str = "/points", detections_topic: str = "/detections") -> None:
        rclpy.init()
        self.node = rclpy.create_node("scanbench_bridge")
        self.publisher = self.node.create_publisher(PointCloud2, points_topic, 1)
        self.node.create_subscription(Detection3DArray, detections_topic, self.keep, 1)
        self.found = None
        self.stamp = 0
        while self.publisher.get_subscription_count() == 0:  # before `configured`, so that the wait is not timed
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def keep(self, message: Detection3DArray) -> None:
        if message.header.stamp.sec == self.stamp:
            self.found = message

    def __call__(self, points: np.ndarray) -> scanbench.Boxes:
        self.stamp += 1  # a scan may be asked for again: no stamp is used twice
        self.found = None
        cloud = PointCloud2(
            height=1, width=len(points), fields=FIELDS, point_step=16, row_step=16 * len(points), is_dense=True
        )
        cloud.header.frame_id = "lidar"
        cloud.header.stamp.sec = self.stamp
        cloud.data = points.tobytes()
        self.publisher.publish(cloud)
        while self.found is None:  # scanbench's time limit ends this if nothing comes
            rclpy.spin_once(self.node, timeout_sec=1.0)
        boxes, scores = [], []
        for detection in self.found.detections:
            center, size, turn = detection.bbox.center.position, detection.bbox.size, detection.bbox.center.orientation
            yaw = 2 * np.arctan2(turn.z, turn.w)  # upright: x and y are 0
            boxes.append([center.x, center.y, center.z, size.x, size.y, size.z, yaw])
            scores.append(detection.results[0].hypothesis.score if detection.results else 0.0)
        return scanbench.Boxes(boxes, scores)
