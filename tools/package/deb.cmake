# cpack -G DEB: libelastin-dev, elastin (command and scenes), and where they are built libelastin1 and libelastin-slim1 (the C
# library, whole and on the core alone: a package's number is the library's) and python3-elastin.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "Elastin")
set(CPACK_PACKAGE_CONTACT "Elastin maintainers <maintainers@users.noreply.h-seed-0a17a840.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(same_version "= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(about "A body of spheres (molecules) joined by connections, and every known way to
set their stiffness: Elastin measures the Young's modulus and Poisson's ratio
that the whole body really has, and sets error against time.
")

# What core needs is a dependency; what only elastin::contact and elastin::lab need comes by default, but may stay away.
set(CPACK_COMPONENTS_ALL development)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libelastin-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS
    "libfcl-dev, libqhull-dev, libyaml-cpp-dev, libfmt-dev, libpugixml-dev, zlib1g-dev, voro++-dev, libceres-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Soft tissue as a molecular model: libraries and headers
${about}
Static libraries for C++20, their CMake package and pkg-config files.")

if(TARGET elastin)
  list(APPEND CPACK_COMPONENTS_ALL command)
  set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME elastin)
  set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_COMMAND_DESCRIPTION "Soft tissue as a molecular model, and the modulus it really has
${about}
The command, with its scenes in /usr/share/elastin/scenes, and the core for pages
of `elastin lab` in /usr/share/elastin/web where it was built.")
endif()

set(C_what "all that the command can do")
set(C_SLIM_what "bodies and simulations on the core alone, without scenes, mesh files and contact")
foreach(c C C_SLIM)
  string(TOLOWER elastin_${c} target)
  if(TARGET ${target})
    get_target_property(output ${target} OUTPUT_NAME)
    get_target_property(soversion ${target} SOVERSION)
    string(REPLACE _ - package lib${output}${soversion})
    string(TOLOWER runtime_${c} component)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    set(CPACK_DEBIAN_RUNTIME_${c}_PACKAGE_NAME ${package})
    set(CPACK_DEBIAN_RUNTIME_${c}_PACKAGE_SECTION libs)
    set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
    set(CPACK_DEBIAN_RUNTIME_${c}_DESCRIPTION "Soft tissue as a molecular model: shared library
${about}
The C library, for programs in any language: ${${c}_what}.")
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", ${package} (${same_version})")
  endif()
endforeach()

if(TARGET elastin_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-elastin)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  get_target_property(suffix elastin_python SUFFIX)  # .cpython-311-…: of this Python alone
  string(REGEX MATCH "cpython-3([0-9]+)" found "${suffix}")
  math(EXPR next "${CMAKE_MATCH_1} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${CMAKE_MATCH_1}), python3 (<< 3.${next}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-meshio, python3-pandas")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Soft tissue as a molecular model: Python bindings
${about}
import elastin: scenes run and bodies stepped, their positions as numpy arrays without a copy.")
endif()

include(CPack)
