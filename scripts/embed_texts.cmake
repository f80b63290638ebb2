# Makes a header of the files in a folder: tone_curve.glsl becomes the text tone_curve.
#   cmake -DFOLDER=src/render/gl/shaders -DHEADER=build/…/shaders.h -DNAMESPACE=cloth::render::shaders
#         -P scripts/embed_texts.cmake
# A shader's program is a list of such pieces, behind the line with GLSL's version (render/gl/gl_objects.h).

file(GLOB files "${FOLDER}/*")
list(SORT files)
set(text "#pragma once\n// Made of ${FOLDER} by every build.\n\nnamespace ${NAMESPACE} {\n")
foreach(file IN LISTS files)
  get_filename_component(name "${file}" NAME_WE)
  file(READ "${file}" source)
  string(APPEND text "\ninline constexpr const char* ${name} = R\"embedded(${source})embedded\";\n")
endforeach()
string(APPEND text "\n}  // namespace ${NAMESPACE}\n")
file(WRITE "${HEADER}" "${text}")
