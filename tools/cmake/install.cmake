# What `cmake --install` puts where, and the package that find_package(tetrakis) finds.
include(CMakePackageConfigHelpers)

set(TETRAKIS_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/tetrakis)

install(TARGETS tetrakis tetrakis_schemes tetrakis_hier tetrakis_refine tetrakis_eval tetrakis_options
        EXPORT tetrakis
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT tetrakis NAMESPACE tetrakis:: FILE tetrakisTargets.cmake DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
foreach(layer schemes hier refine eval)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${layer}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tetrakis/${layer}
          FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/generated/tetrakis/hier/version.hpp
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tetrakis/hier)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET tetrakis_cli)
  install(TARGETS tetrakis_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# Not at the top of the build tree, which find_package() searches where the program's folder is on PATH: the file works
# only where it is installed, beside its targets.
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/tetrakisConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/package/tetrakisConfig.cmake
                              INSTALL_DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/tetrakisConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/tetrakisConfig.cmake ${PROJECT_BINARY_DIR}/package/tetrakisConfigVersion.cmake
        DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
