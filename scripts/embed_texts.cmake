# Makes a header of text files: tone_curve.glsl becomes the text NAMESPACE::tone_curve, page.css NAMESPACE::page_css.
#   cmake "-DFILES=a.glsl;b.css" -DNAMESPACE=cloth::render::shaders -DHEADER=build/…/shaders.h -P scripts/embed_texts.cmake

set(text "#pragma once\n#pragma GCC system_header  // its texts are longer than a compiler must take\n")
string(APPEND text "// Made by every build.\n\nnamespace ${NAMESPACE} {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  string(REGEX REPLACE "[.]glsl$" "" name "${name}")
  string(MAKE_C_IDENTIFIER "${name}" name)
  file(READ "${file}" source)
  string(APPEND text "\ninline constexpr const char* ${name} = R\"embedded(${source})embedded\";\n")
endforeach()
string(APPEND text "\n}  // namespace ${NAMESPACE}\n")
file(WRITE "${HEADER}" "${text}")
