# elastin_library(NAME sources…): the static library elastin_NAME, known as elastin::NAME, with the project's options.
# Its sources include public headers from include/ and private ones from src/.
function(elastin_library name)
  add_library(elastin_${name} STATIC ${ARGN})
  add_library(elastin::${name} ALIAS elastin_${name})
  target_compile_features(elastin_${name} PUBLIC cxx_std_20)
  target_include_directories(elastin_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(elastin_${name} PRIVATE $<BUILD_INTERFACE:elastin_options>)
endfunction()
