# cmake --install: libraries with their CMake package and pkg-config files, headers, the command, the scenes, and what was built for browsers.
include(CMakePackageConfigHelpers)
include(CheckCXXSourceCompiles)

# What one part of a program allocates by Eigen another frees: its users must do it as the libraries were built to do it,
# and base/types.h refuses those that are compiled for other vectors. Eigen asks malloc itself where that aligns enough.
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
foreach(alignment 16 32 64)
  check_cxx_source_compiles("#include <Eigen/Core>
    static_assert(EIGEN_DEFAULT_ALIGN_BYTES == ${alignment}); int main() {}" ELASTIN_ALIGNED_${alignment})
  if(ELASTIN_ALIGNED_${alignment})
    set(elastin_alignment ${alignment})
    break()
  endif()
endforeach()
check_cxx_source_compiles("#include <Eigen/Core>
  static_assert(EIGEN_MALLOC_ALREADY_ALIGNED); int main() {}" ELASTIN_ALIGNED_BY_MALLOC)
unset(CMAKE_REQUIRED_LIBRARIES)
set(by_malloc 0)
if(ELASTIN_ALIGNED_BY_MALLOC)
  set(by_malloc 1)
endif()
set(eigen_memory ELASTIN_ALIGNMENT=${elastin_alignment} EIGEN_MALLOC_ALREADY_ALIGNED=${by_malloc})
target_compile_definitions(elastin_core INTERFACE "$<INSTALL_INTERFACE:${eigen_memory}>")

set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/elastin)
set(components core openmp)
if(ELASTIN_CONTACT)
  list(APPEND components hull contact)
endif()
if(ELASTIN_LAB)
  list(APPEND components mesh config lab)
  if(ELASTIN_FEBIO)
    list(APPEND components febio)
    set(febio febio)
  endif()
  list(APPEND components command)
endif()
foreach(component IN LISTS components)
  set_target_properties(elastin_${component} PROPERTIES EXPORT_NAME ${component})
  install(TARGETS elastin_${component} EXPORT elastin-${component} COMPONENT development
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT elastin-${component} FILE elastin-${component}-targets.cmake NAMESPACE elastin::
          DESTINATION ${cmake_folder} COMPONENT development)
endforeach()
foreach(c c c_slim)
  if(TARGET elastin_${c})  # shared: asks nothing of its users
    list(APPEND components ${c})
    set_target_properties(elastin_${c} PROPERTIES EXPORT_NAME ${c})
    install(TARGETS elastin_${c} EXPORT elastin-${c} LIBRARY COMPONENT runtime_${c} NAMELINK_COMPONENT development
            INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    install(EXPORT elastin-${c} FILE elastin-${c}-targets.cmake NAMESPACE elastin:: DESTINATION ${cmake_folder}
            COMPONENT development)
  endif()
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

list(TRANSFORM eigen_memory PREPEND " -D" OUTPUT_VARIABLE eigen_flags)
list(JOIN eigen_flags "" eigen_flags)
# The prefix is found from where the .pc file lies, so that the whole may be moved.
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH up_to_prefix /${pkgconfig_folder} /)
string(REGEX REPLACE "/$" "" up_to_prefix "${up_to_prefix}")
foreach(component core contact c c_slim)
  if(TARGET elastin_${component})
    get_target_property(output_name elastin_${component} OUTPUT_NAME)
    string(REPLACE "c_slim" "c" template ${component})
    string(REPLACE _ - file elastin-${component}.pc)
    configure_file(tools/package/elastin-${template}.pc.in ${PROJECT_BINARY_DIR}/${file} @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/${file} DESTINATION ${pkgconfig_folder} COMPONENT development)
  endif()
endforeach()

if(TARGET elastin)
  install(TARGETS elastin COMPONENT command)
  if(TARGET elastin_later)
    install(TARGETS elastin_later LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/elastin COMPONENT command)
  endif()
  if(TARGET elastin-petsc)
    install(TARGETS elastin-petsc COMPONENT command)
  endif()
  install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/elastin COMPONENT command)
  # What `elastin lab` puts into its pages, where tools/setup --web has built it.
  install(FILES ${PROJECT_BINARY_DIR}/web/bin/elastin.js ${PROJECT_BINARY_DIR}/web/bin/elastin.wasm
          DESTINATION ${CMAKE_INSTALL_DATADIR}/elastin/web COMPONENT command OPTIONAL)
endif()

# The paths that a shell needs where the prefix is not one of the system's.
string(CONFIGURE [=[
if(NOT CMAKE_INSTALL_PREFIX MATCHES "^/usr(/local)?$" AND NOT DEFINED CPACK_INSTALL_PREFIX AND NOT "$ENV{DESTDIR}")
  message("export PATH=${CMAKE_INSTALL_PREFIX}/@CMAKE_INSTALL_BINDIR@:$PATH
export CMAKE_PREFIX_PATH=${CMAKE_INSTALL_PREFIX}:$CMAKE_PREFIX_PATH
export PKG_CONFIG_PATH=${CMAKE_INSTALL_PREFIX}/@pkgconfig_folder@:$PKG_CONFIG_PATH
export LD_LIBRARY_PATH=${CMAKE_INSTALL_PREFIX}/@CMAKE_INSTALL_LIBDIR@:$LD_LIBRARY_PATH
export PYTHONPATH=${CMAKE_INSTALL_PREFIX}/@ELASTIN_PYTHON_DIR@:$PYTHONPATH")
endif()]=] paths_to_set @ONLY)
install(CODE "${paths_to_set}" COMPONENT development)
