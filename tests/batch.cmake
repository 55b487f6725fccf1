# Writes a source that is several files of tests: cmake -D OUT=FILE -D "FILES=FILE;FILE" -P batch.cmake
# The headers of all come first; then each file is in a namespace of its own, since helpers of one name stand in many.
set(includes)
set(bodies)
foreach(file IN LISTS FILES)
  file(STRINGS ${file} own REGEX "^#include")
  list(APPEND includes ${own})
  string(MAKE_C_IDENTIFIER ${file} name)
  string(APPEND bodies "namespace in${name} {\n#include \"${file}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES includes)
list(JOIN includes "\n" includes)
file(WRITE ${OUT} "${includes}\n${bodies}")
