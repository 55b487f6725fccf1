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
