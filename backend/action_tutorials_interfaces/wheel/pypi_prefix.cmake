# Lets the unchanged CMakeLists.txt find ROS 2 in the Python environment that
# builds the wheel. `colcon build` never reads this file.
#
# scikit-build-core includes it through CMAKE_PROJECT_INCLUDE, right after project().

cmake_path(GET Python3_EXECUTABLE PARENT_PATH _bin)
cmake_path(GET _bin PARENT_PATH _prefix)
if(EXISTS "${_prefix}/share/ament_index") # otherwise ROS is sourced
  set(ENV{AMENT_PREFIX_PATH} "${_prefix}")
  list(PREPEND CMAKE_PREFIX_PATH "${_prefix}")
endif()

# The ROS wheels export include directories of the machine that built them
# (/opt/python/...). CMake refuses an imported target with a directory that does
# not exist, so those are dropped once every package has been found.
function(_drop_missing_include_directories)
  get_property(_targets DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" PROPERTY IMPORTED_TARGETS)
  foreach(_target IN LISTS _targets)
    get_target_property(_directories ${_target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT _directories)
      continue()
    endif()
    set(_present "")
    foreach(_directory IN LISTS _directories)
      if(_directory MATCHES "\\$<" OR EXISTS "${_directory}")
        list(APPEND _present "${_directory}")
      endif()
    endforeach()
    set_target_properties(${_target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${_present}")
  endforeach()
endfunction()
cmake_language(DEFER DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" CALL _drop_missing_include_directories)
