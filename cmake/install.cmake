# Installation: the library with its headers, the program, and the package that
# find_package(vasamesh) reads.
include(CMakePackageConfigHelpers)
set(VASAMESH_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/vasamesh)

install(TARGETS vasamesh EXPORT vasamesh ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY engine/include/ host/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")
install(EXPORT vasamesh NAMESPACE vasamesh:: FILE vasamesh-targets.cmake
  DESTINATION ${VASAMESH_PACKAGE_DIR})

configure_package_config_file(cmake/vasamesh-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/vasamesh-config.cmake INSTALL_DESTINATION ${VASAMESH_PACKAGE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/vasamesh-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/vasamesh-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/vasamesh-config-version.cmake
  DESTINATION ${VASAMESH_PACKAGE_DIR})

if(TARGET vasamesh_cli)
  install(TARGETS vasamesh_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
