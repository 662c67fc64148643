# find_package(bearing_calibration), as catkin packages do it, has the target bearing_calibration::core,
# too. In a workspace that is built as one it is there already.
if(NOT TARGET bearing_calibration::core)
  find_package(bearing_calibration_core REQUIRED CONFIG HINTS ${bearing_calibration_DIR}/../../..)
endif()
