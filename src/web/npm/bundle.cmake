# Writes browser.mjs of the package's folder: cmake -DFOLDER=… -DTEMPLATE=… -P bundle.cmake
foreach(part elastin face index)
  file(READ ${FOLDER}/${part}.js ${part})
endforeach()
configure_file(${TEMPLATE} ${FOLDER}/browser.mjs @ONLY)
