"""Nav2 with Floorwalker as its simulator: ros2 launch ./nav2.launch.py trial:=aisle.trial.yaml.

Floorwalker serves clock, transforms, map, odometry and scan. Nav2 plans and sends cmd_vel.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

HERE = Path(__file__).parent


def generate_launch_description():
    """Return the simulator and Nav2's servers, without localization and map server."""
    nav2 = Path(get_package_share_directory("nav2_bringup"))
    names = ("trial", "speed", "params_file")
    trial, speed, parameters = map(LaunchConfiguration, names)
    usual = (HERE / "aisle.trial.yaml", "1.0", nav2 / "params" / "nav2_params.yaml")
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=str(value))
                for name, value in zip(names, usual, strict=True)
            ),
            ExecuteProcess(cmd=["floorwalker", "ros2", trial, "--speed", speed], output="screen"),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(nav2 / "launch" / "navigation_launch.py")),
                launch_arguments={"use_sim_time": "true", "params_file": parameters}.items(),
            ),
        ]
    )
