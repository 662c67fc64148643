# The core library alone, without ROS: target bearing_calibration::core
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/bearing_calibration_coreTargets.cmake)
