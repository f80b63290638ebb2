# Makes a header of the GLSL files in a folder: tone_curve.glsl becomes the text cloth::render::shaders::tone_curve.
#   cmake -DFOLDER=src/render/gl/shaders -DHEADER=build/…/shaders.h -P scripts/embed_shaders.cmake
# A program is a list of such pieces, behind the line with GLSL's version (render/gl/gl_objects.h).

file(GLOB files "${FOLDER}/*.glsl")
list(SORT files)
set(text "#pragma once\n// Made of ${FOLDER} by every build.\n\nnamespace cloth::render::shaders {\n")
foreach(file IN LISTS files)
  get_filename_component(name "${file}" NAME_WE)
  file(READ "${file}" source)
  string(APPEND text "\ninline constexpr const char* ${name} = R\"glsl(${source})glsl\";\n")
endforeach()
string(APPEND text "\n}  // namespace cloth::render::shaders\n")
file(WRITE "${HEADER}" "${text}")
