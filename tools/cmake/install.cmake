# What `cmake --install` puts where, and the package that find_package(tetrakis) finds.
include(CMakePackageConfigHelpers)

set(TETRAKIS_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/tetrakis)

install(TARGETS tetrakis EXPORT tetrakis
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tetrakis)
install(EXPORT tetrakis NAMESPACE tetrakis:: FILE tetrakisTargets.cmake DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/package/tetrakis.hpp @ONLY
     CONTENT "#pragma once\n#include \"eval/tetrakis.hpp\"\n")
install(FILES ${PROJECT_BINARY_DIR}/package/tetrakis.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tetrakis)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET tetrakis_c)
  install(TARGETS tetrakis_c LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          PUBLIC_HEADER DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tetrakis)
endif()
if(TARGET tetrakis_cli)
  install(TARGETS tetrakis_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# Not at the top of the build tree, which find_package() searches where the program's folder is on PATH: the file works
# only where it is installed, beside its targets.
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/tetrakisConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/package/tetrakisConfig.cmake
                              INSTALL_DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/tetrakisConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/tetrakisConfig.cmake
              ${PROJECT_BINARY_DIR}/package/tetrakisConfigVersion.cmake
        DESTINATION ${TETRAKIS_INSTALL_CMAKEDIR})
