# The library other programs embed: one shared library that shows only perigee.h, made of the room that implements it and
# of what that needs from the rooms below (no importer); its pkg-config and CMake files; and what else
# `cmake --install` lays down.
include(CMakePackageConfigHelpers)

add_library(perigee_lib SHARED $<TARGET_OBJECTS:perigee_render>)
target_link_libraries(perigee_lib PRIVATE perigee_flags perigee_render)
target_link_options(perigee_lib PRIVATE -Wl,--as-needed
    -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/perigee.map)
target_include_directories(perigee_lib PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
set_target_properties(perigee_lib PROPERTIES
    OUTPUT_NAME perigee EXPORT_NAME perigee
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    LINKER_LANGUAGE C)

# Where perigee.pc lies to the prefix, so that an installed tree may be moved.
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/perigee.pc.in perigee.pc @ONLY)
configure_package_config_file(cmake/perigee-config.cmake.in perigee-config.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/perigee)
write_basic_package_version_file(perigee-config-version.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS perigee RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS perigee_lib EXPORT perigee-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES src/perigee.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT perigee-targets NAMESPACE perigee:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/perigee)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/perigee-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/perigee-config-version.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/perigee)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/perigee.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(DIRECTORY data/ DESTINATION ${CMAKE_INSTALL_DATADIR}/perigee)
install(FILES doc/perigee.1 doc/perigee-compare.1 doc/perigee-import.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
