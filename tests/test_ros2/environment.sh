#!/usr/bin/env bash
# Make the ROS environment of these tests: environment.sh FOLDER [INTERFACES]
#
# FOLDER gets a virtual environment with rclpy and message packages of ROS 2 Kilted. What is there already is kept.
# INTERFACES has a folder of definitions (.msg, .srv, .action) for each message package that has no wheel: nav2_msgs,
# people_msgs, hunav_msgs, simulation_interfaces. Tests that need one without definitions are skipped.
set -euo pipefail

folder=$(realpath -m "$1")
interfaces=${2:-}
here=$(cd "$(dirname "$0")" && pwd)
environment=$folder/venv
mkdir -p "$folder"

wheels=(
    ros-rclpy==9.1.2 ros-rmw-fastrtps-cpp==9.3.3
    ros-{std,geometry,nav,sensor,diagnostic,trajectory,visualization}-msgs==5.5.1 ros-std-srvs==5.5.1
    # Building messages needs more, which no wheel requires.
    ros-ament-{package==0.17.2,cmake{,-include-directories,-gmock,-gtest,-pytest,-vendor-package}==2.7.3}
    ros-ament-cmake-ros{,-core}==0.14.5 ros-rosidl-core-generators==0.3.1
    catkin_pkg cmake ninja
)
ready=$folder/wheels-$(python3 -c "import sys; print(sys.implementation.cache_tag)")
if ! [ -e "$ready" ]; then
    rm -rf "$folder"/wheels-* "$folder/build"
    python3 -m venv --clear "$environment"
    "$environment/bin/pip" install --quiet --disable-pip-version-check "${wheels[@]}"
    # The CMake files of the wheels name the Python that they were built with.
    include=$("$environment/bin/python" -c "import sysconfig; print(sysconfig.get_path('include'))")
    numpy=$("$environment/bin/python" -c "import numpy; print(numpy.get_include())")
    grep -rl /opt/python "$environment/share" --include="*.cmake" | xargs -r sed -i -E \
        -e "s#/opt/python/[^\";]*/numpy/_?core/include#$numpy#g" -e "s#/opt/python/[^\";]*/include/python[0-9.]*#$include#g"
    touch "$ready"
fi

build() {  # the message package NAME from the folder DEFINITIONS: its files, or those that match an expression
    local name=$1 definitions=$2 source=$folder/build/$1 files
    files=$(cd "$definitions" && find . -name "*.msg" -o -name "*.srv" -o -name "*.action" | sed 's#^\./##' | sort | grep -E "^($3)\$")
    if [ -e "$source/done" ] && [ "$files" = "$(cat "$source/all")" ]; then return 0; fi
    rm -rf "$source" && mkdir -p "$source"
    echo "$files" >"$source/all"
    while read -r file; do install -D "$definitions/$file" "$source/$file"; done <"$source/all"
    local needs
    needs=$(cd "$source" && xargs grep -hoE '^[a-z0-9_]+_(msgs|interfaces)/' <"$source/all" | tr -d / | sort -u | grep -vx "$name" || true)
    {
        echo "<package format=\"3\"><name>$name</name><version>1.0.0</version><description>Messages</description>"
        echo "<maintainer email=\"nobody@example.com\">Nobody</maintainer><license>Apache-2.0</license>"
        echo "<buildtool_depend>ament_cmake</buildtool_depend>"
        for need in $needs action_msgs; do echo "<depend>$need</depend>"; done
        echo "<member_of_group>rosidl_interface_packages</member_of_group></package>"
    } >"$source/package.xml"
    {
        echo "cmake_minimum_required(VERSION 3.20)"
        echo "project($name C CXX)"
        for package in ament_cmake rosidl_cmake rosidl_generator_type_description rosidl_generator_c rosidl_typesupport_fastrtps_c \
            rosidl_typesupport_c rosidl_generator_py $needs; do
            echo "find_package($package REQUIRED)"
        done
        # rclpy needs the C and Python parts only.
        echo "list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX cpp)"
        echo "rosidl_generate_interfaces($name $(tr '\n' ' ' <"$source/all")" ${needs:+DEPENDENCIES $needs} ")"
        echo "ament_package()"
    } >"$source/CMakeLists.txt"
    cmake -S "$source" -B "$source/build" -G Ninja -DCMAKE_INSTALL_PREFIX="$environment" -DCMAKE_PREFIX_PATH="$environment" \
        -DPython3_EXECUTABLE="$environment/bin/python" -DCMAKE_BUILD_TYPE=None -DCMAKE_C_FLAGS=-O0 -DCMAKE_CXX_FLAGS=-O0 \
        >"$source/log" 2>&1 && cmake --build "$source/build" --target install >>"$source/log" 2>&1 ||
        { tail -20 "$source/log" >&2; return 1; }
    touch "$source/done"
}

export PATH="$environment/bin:$PATH" AMENT_PREFIX_PATH="$environment" LD_LIBRARY_PATH="$environment/lib"
unset PYTHONPATH

needed() {  # the definitions that the tests use, as an expression
    case $1 in
        nav2_msgs) echo 'action/(NavigateToPose|NavigateThroughPoses|FollowWaypoints|FollowPath)\.action|msg/WaypointStatus\.msg' ;;
        people_msgs) echo 'msg/(Person|People)\.msg' ;;
        hunav_msgs) echo 'msg/Agents?\.msg|srv/(Compute|Get|Reset)Agents\.srv' ;;
        simulation_interfaces) echo 'msg/.*|action/.*|srv/(ResetSimulation|Get(SimulatorFeatures|SimulationState|Entities|EntitiesStates|EntityState|EntityInfo|EntityBounds|NamedPoses|CurrentWorld)|Set(SimulationState|EntityState)|StepSimulation)\.srv' ;;
        *) echo '.*' ;;
    esac
}

for name in tf2_msgs control_msgs ariac_msgs people_msgs nav2_msgs hunav_msgs simulation_interfaces; do
    for definitions in "$here/interfaces/$name" ${interfaces:+"$interfaces/$name" "$interfaces/$name-kilted"}; do
        if [ -d "$definitions" ]; then build "$name" "$definitions" "$(needed "$name")"; fi
    done
done
