# The program, the static libraries with their headers, and a package for find_package(gnomon): targets gnomon::core,
# gnomon::raster, gnomon::raytrace, gnomon::techniques and gnomon::eval.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/gnomon)
set(modules core raster raytrace techniques eval)

install(TARGETS gnomon-cli)
list(TRANSFORM modules PREPEND gnomon- OUTPUT_VARIABLE libraries)
install(TARGETS ${libraries} EXPORT gnomon)
install(DIRECTORY ${modules} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gnomon FILES_MATCHING PATTERN "*.h")
install(EXPORT gnomon NAMESPACE gnomon:: FILE gnomonTargets.cmake DESTINATION ${package_folder})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/gnomonConfig.cmake.in ${CMAKE_BINARY_DIR}/gnomonConfig.cmake
  INSTALL_DESTINATION ${package_folder} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/gnomonConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/gnomonConfig.cmake ${CMAKE_BINARY_DIR}/gnomonConfigVersion.cmake
  DESTINATION ${package_folder})
