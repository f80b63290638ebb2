# What `cmake --install` and CPack leave: the program with its scenes, page for man and completion for bash (component
# program), and the libraries for programs of others, found by find_package(render_cloth) (component development).
# Included by CMakeLists.txt.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The program looks for its assets beside itself: in ../share/render_cloth where it is installed, in assets where it is
# built. RENDER_CLOTH_ASSETS is another folder to look in first.
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/assets ${PROJECT_BINARY_DIR}/assets SYMBOLIC)
install(TARGETS render_cloth RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(DIRECTORY assets/scenes assets/meshes DESTINATION ${CMAKE_INSTALL_DATADIR}/render_cloth COMPONENT program)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# The program writes about itself, where it runs.
if(NOT CMAKE_CROSSCOMPILING)
  set(about ${PROJECT_BINARY_DIR}/about)
  file(MAKE_DIRECTORY ${about})
  foreach(entry "manual|render_cloth.1" "completion|render_cloth")
    string(REPLACE "|" ";" entry "${entry}")
    list(GET entry 0 what)
    list(GET entry 1 file)
    add_custom_command(OUTPUT ${about}/${file} COMMAND render_cloth list ${what} > ${about}/${file}
                       DEPENDS render_cloth VERBATIM)
    list(APPEND about_files ${about}/${file})
  endforeach()
  add_custom_target(about ALL DEPENDS ${about_files})
  install(FILES ${about}/render_cloth.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${about}/render_cloth DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          COMPONENT program)
endif()

# ---------------------------------------------------------------- the libraries
set(CLOTH_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/render_cloth)
foreach(library flags base sim render pipeline)
  set_target_properties(cloth_${library} PROPERTIES EXPORT_NAME ${library})
endforeach()
install(TARGETS cloth_flags cloth_base cloth_sim cloth_render cloth_pipeline EXPORT render_cloth
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(EXPORT render_cloth NAMESPACE render_cloth:: FILE render_cloth-targets.cmake
        DESTINATION ${CLOTH_PACKAGE_FOLDER} COMPONENT development)
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/render_cloth COMPONENT development
        FILES_MATCHING PATTERN "*.h" PATTERN "validation" EXCLUDE)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
configure_package_config_file(scripts/render_cloth-config.cmake.in ${PROJECT_BINARY_DIR}/render_cloth-config.cmake
                              INSTALL_DESTINATION ${CLOTH_PACKAGE_FOLDER})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/render_cloth-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/render_cloth-config.cmake
              ${PROJECT_BINARY_DIR}/render_cloth-config-version.cmake
        DESTINATION ${CLOTH_PACKAGE_FOLDER} COMPONENT development)

# ---------------------------------------------------------------- .deb and .tar.gz: cpack
set(CPACK_GENERATOR "TGZ;DEB")
set(CPACK_PACKAGE_NAME render-cloth)
set(CPACK_PACKAGE_VENDOR "render_cloth")
set(CPACK_PACKAGE_CONTACT "render_cloth")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Simulates cloth, draws every frame, and makes a movie of it")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_ARCHIVE_COMPONENT_INSTALL OFF)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME render-cloth)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# Loaded or started by name while it runs.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libosmesa6 | libegl1")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "ffmpeg, libosmesa6")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME librender-cloth-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libeigen3-dev, libtbb-dev, libassimp-dev, zlib1g-dev, libfmt-dev, libtomlplusplus-dev, libzstd-dev, libxxhash-dev, libdeflate-dev, libminizip-dev, libmuparser-dev, pkg-config")
include(CPack)
