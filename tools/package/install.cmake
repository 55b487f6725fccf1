# cmake --install: libraries with their CMake package and pkg-config files, headers, the command, the scenes.
include(CMakePackageConfigHelpers)
include(CheckCXXSourceCompiles)

# What one part of a program allocates by Eigen another frees, so all must align alike, also those that are compiled for
# a wider machine (-march=native): users get the alignment that the libraries were built with.
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
foreach(alignment 16 32 64)
  check_cxx_source_compiles("#include <Eigen/Core>
                             static_assert(EIGEN_MAX_ALIGN_BYTES == ${alignment}); int main() {}" ELASTIN_ALIGN_${alignment})
  if(ELASTIN_ALIGN_${alignment})
    set(eigen_alignment EIGEN_MAX_ALIGN_BYTES=${alignment})
    target_compile_definitions(elastin_core INTERFACE $<INSTALL_INTERFACE:${eigen_alignment}>)
    break()
  endif()
endforeach()
unset(CMAKE_REQUIRED_LIBRARIES)

set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/elastin)
set(components core openmp)
if(ELASTIN_CONTACT)
  list(APPEND components contact)
endif()
if(ELASTIN_LAB)
  list(APPEND components lab)
endif()
foreach(component IN LISTS components)
  set_target_properties(elastin_${component} PROPERTIES EXPORT_NAME ${component})
  install(TARGETS elastin_${component} EXPORT elastin-${component} COMPONENT development
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT elastin-${component} FILE elastin-${component}-targets.cmake NAMESPACE elastin::
          DESTINATION ${cmake_folder} COMPONENT development)
endforeach()
install(DIRECTORY include/elastin DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)

set(openmp_needs "")
if(OpenMP_CXX_FOUND)
  set(openmp_needs OpenMP)
endif()
list(JOIN components " " components)
configure_package_config_file(tools/package/elastin-config.cmake.in ${PROJECT_BINARY_DIR}/elastin-config.cmake
                              INSTALL_DESTINATION ${cmake_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/elastin-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/elastin-config.cmake ${PROJECT_BINARY_DIR}/elastin-config-version.cmake
        tools/package/FindVoro++.cmake DESTINATION ${cmake_folder} COMPONENT development)

# The prefix is found from where the .pc file lies, so that the whole may be moved.
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH up_to_prefix /${pkgconfig_folder} /)
string(REGEX REPLACE "/$" "" up_to_prefix "${up_to_prefix}")
foreach(component core contact)
  if(TARGET elastin_${component})
    configure_file(tools/package/elastin-${component}.pc.in ${PROJECT_BINARY_DIR}/elastin-${component}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/elastin-${component}.pc DESTINATION ${pkgconfig_folder} COMPONENT development)
  endif()
endforeach()

if(TARGET elastin)
  install(TARGETS elastin COMPONENT command)
  install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/elastin COMPONENT command)
endif()
