# Writes a header with fingerprints of the program's source text: of what decides states, and of all of it.
#   cmake -DSOURCE=… -DHEADER=… -P scripts/fingerprint_sources.cmake
function(fingerprint_of result)
  set(sums "")
  foreach(folder IN LISTS ARGN)
    file(GLOB_RECURSE files RELATIVE "${SOURCE}" "${SOURCE}/${folder}/*.h" "${SOURCE}/${folder}/*.cpp"
         "${SOURCE}/${folder}/*.glsl")
    foreach(each IN LISTS files)
      file(SHA256 "${SOURCE}/${each}" sum)
      string(APPEND sums "${each} ${sum}\n")
    endforeach()
  endforeach()
  string(SHA256 sum "${sums}")
  string(SUBSTRING "${sum}" 0 16 sum)
  set(${result} "${sum}" PARENT_SCOPE)
endfunction()

fingerprint_of(physics src/base src/sim)
fingerprint_of(all src)
file(CONFIGURE OUTPUT "${HEADER}" CONTENT "#pragma once
#define CLOTH_PHYSICS_SOURCES \"${physics}\"
#define CLOTH_ALL_SOURCES \"${all}\"
")
