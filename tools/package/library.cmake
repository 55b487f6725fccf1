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
  target_compile_features(elastin_${name} PUBLIC cxx_std_20)
  target_include_directories(elastin_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(elastin_${name} PRIVATE $<BUILD_INTERFACE:elastin_options>)
  # A room is compiled as one: what its files name for themselves alone, they name once in the room.
  set_target_properties(elastin_${name} PROPERTIES UNITY_BUILD_MODE GROUP)
  foreach(source ${ARGN})
    string(REGEX MATCH "^${CMAKE_CURRENT_SOURCE_DIR}/([^/]*)/" folder "${source}")
    if(NOT "${name}_${CMAKE_MATCH_1}" IN_LIST ELASTIN_SPLIT)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${name}_${CMAKE_MATCH_1}")
    endif()
  endforeach()
endfunction()
