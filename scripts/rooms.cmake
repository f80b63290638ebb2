# Arrows between the rooms of src/ run one way: a file includes only its own room and the rooms named before it in
# its tower's list. Run by every build and by the tests:
#   cmake -P scripts/rooms.cmake
# A room is a folder, or a pair of files that stands between folders.

set(sim
  base
  sim/algebra sim/geometry sim/scene sim/assignment sim/motion sim/shapes sim/energies
  sim/model
  sim/contact sim/stepping sim/fields
  sim/simulation)
set(render
  base
  render/frame render/vector_math render/image render/overlay render/gl render/raster)
set(validation ${sim} validation)
set(pipeline ${sim} ${render}
  pipeline/formats pipeline/scene_file pipeline/picture pipeline/page pipeline/run pipeline/sweep pipeline/golden)
set(python ${pipeline} python)
set(apps ${validation} ${pipeline} apps/cli apps/verbs apps/main)

if(NOT ROOT)
  get_filename_component(ROOT "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
endif()

# The room of a path like "sim/algebra/types.h", by the longest name that begins it; empty: none.
function(room_of path rooms result)
  set(best "")
  foreach(room IN LISTS rooms)
    if(path MATCHES "^${room}[/.]")
      set(best "${room}")
    endif()
  endforeach()
  set(${result} "${best}" PARENT_SCOPE)
endfunction()

set(faults "")
file(GLOB_RECURSE files RELATIVE "${ROOT}" "${ROOT}/src/*.h" "${ROOT}/src/*.cpp" "${ROOT}/apps/*.h" "${ROOT}/apps/*.cpp")
foreach(file IN LISTS files)
  string(REGEX REPLACE "^src/" "" path "${file}")
  string(REGEX MATCH "^[^/]+" tower "${path}")
  if(tower STREQUAL "base")
    set(tower sim)
  endif()
  set(rooms ${${tower}})
  room_of("${path}" "${rooms}" own)
  if(own STREQUAL "")
    list(APPEND faults "${file}: stands in no room, scripts/rooms.cmake lists them")
    continue()
  endif()
  list(FIND rooms "${own}" floor)
  file(STRINGS "${ROOT}/${file}" includes REGEX "^#include \"")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
    room_of("${included}" "${rooms}" there)
    list(FIND rooms "${there}" other)
    if(there STREQUAL "")
      list(APPEND faults "${file}: includes \"${included}\", which is in no room that ${own} may see")
    elseif(other GREATER floor)
      list(APPEND faults "${file}: includes \"${included}\": ${there} stands above ${own}")
    endif()
  endforeach()
endforeach()
if(faults)
  list(JOIN faults "\n  " faults)
  message(FATAL_ERROR "Arrows between rooms must run down:\n  ${faults}")
endif()
