# elastin_rooms(SOURCES rooms…): sets SOURCES to the sources of these folders, bottom up: a room includes itself and those
# before it. tools/check_tree reads the list here; the compiler, which sees one root of all headers, cannot.
function(elastin_rooms result)
  foreach(room ${ARGN})
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${room}/*.cpp)
    list(APPEND all ${sources})
  endforeach()
  set(${result} ${all} PARENT_SCOPE)
endfunction()

# elastin_library(NAME sources…): the library elastin_NAME, known as elastin::NAME, with the project's options: static, or
# shared with BUILD_SHARED_LIBS. The layout of C++ classes may change with each version, so that its number is the soname's.
# Its sources include public headers from include/ and private ones from src/.
function(elastin_library name)
  add_library(elastin_${name} ${ARGN})
  set_target_properties(elastin_${name} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION})
  add_library(elastin::${name} ALIAS elastin_${name})
  elastin_compile(elastin_${name} ${name} ${ARGN})
endfunction()

# elastin_library_in_two(NAME REGEX sources…): the same; those sources that do not match are the objects elastin_NAME_first as
# well, all that the program elastin_first has of the library. elastin_first_alike(NAME) compiles them as what the library
# links and asks for until then says.
function(elastin_library_in_two name regex)
  set(first ${ARGN})
  list(FILTER first EXCLUDE REGEX ${regex})
  list(REMOVE_ITEM ARGN ${first})
  add_library(elastin_${name}_first OBJECT ${first})
  elastin_compile(elastin_${name}_first ${name} ${first})
  elastin_library(${name} ${ARGN} $<TARGET_OBJECTS:elastin_${name}_first>)
endfunction()

function(elastin_first_alike name)
  foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES COMPILE_DEFINITIONS COMPILE_OPTIONS)
    get_target_property(value elastin_${name} ${property})
    if(value)
      list(TRANSFORM value REPLACE "^elastin_lab$" elastin_lab_first)
      set_target_properties(elastin_${name}_first PROPERTIES ${property} "${value}")
    endif()
  endforeach()
endfunction()

function(elastin_compile target name)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:elastin_options>)
  # A room is compiled as one: what its files name for themselves alone, they name once in the room.
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP DEFINE_SYMBOL "")
  foreach(source ${ARGN})
    string(REGEX MATCH "^${CMAKE_CURRENT_SOURCE_DIR}/([^/]*)/" folder "${source}")
    if(NOT "${name}_${CMAKE_MATCH_1}" IN_LIST ELASTIN_SPLIT)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${name}_${CMAKE_MATCH_1}")
    endif()
  endforeach()
endfunction()

# elastin_loads_later(TARGET FOLDER): a program or shared library that needs no FCL and no Ceres before the module
# elastin_later is loaded, from FOLDER, built and installed.
function(elastin_loads_later target folder)
  set(source ${PROJECT_SOURCE_DIR}/src/command/later.cpp)
  target_sources(${target} PRIVATE ${source})
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
                              COMPILE_DEFINITIONS ELASTIN_LATER="$<TARGET_FILE_NAME:elastin_later>")
  target_link_options(${target} PRIVATE -Wl,--as-needed)
  target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  set_target_properties(${target} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH ${folder})
  add_dependencies(${target} elastin_later)
endfunction()

# elastin_has_later(TARGET FOLDER COMPONENT INSTALLED): the same of a shared library with a copy of the module of its own,
# so that packages do not share a file: in FOLDER next to it, which is INSTALLED there.
function(elastin_has_later target folder component installed)
  elastin_loads_later(${target} $ORIGIN/${folder})
  add_custom_command(TARGET ${target} POST_BUILD
                     COMMAND ${CMAKE_COMMAND} -E make_directory $<TARGET_FILE_DIR:${target}>/${folder}
                     COMMAND ${CMAKE_COMMAND} -E copy $<TARGET_FILE:elastin_later> $<TARGET_FILE_DIR:${target}>/${folder}
                     VERBATIM)
  if(ELASTIN_INSTALL)
    install(FILES $<TARGET_FILE:elastin_later> DESTINATION ${installed}/${folder} COMPONENT ${component})
  endif()
endfunction()
