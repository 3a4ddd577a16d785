//! A robot of ROS 2, and tools of ROS 2, over DDS: rclpy with Fast DDS on the other side.

mod drives;
mod tools;
