# The target tetrakis_opensubdiv, where OpenSubdiv is installed. Debian's own CMake package names a static library that it
# does not ship, so find_package(OpenSubdiv) stops every configuration: look for header and library instead.
if(NOT TARGET tetrakis_opensubdiv)
  find_path(TETRAKIS_OPENSUBDIV_INCLUDE_DIR opensubdiv/bfr/surface.h)
  find_library(TETRAKIS_OPENSUBDIV_LIBRARY osdCPU)
  mark_as_advanced(TETRAKIS_OPENSUBDIV_INCLUDE_DIR TETRAKIS_OPENSUBDIV_LIBRARY)
  if(TETRAKIS_OPENSUBDIV_INCLUDE_DIR AND TETRAKIS_OPENSUBDIV_LIBRARY)
    add_library(tetrakis_opensubdiv INTERFACE)
    target_include_directories(tetrakis_opensubdiv SYSTEM INTERFACE ${TETRAKIS_OPENSUBDIV_INCLUDE_DIR})
    target_link_libraries(tetrakis_opensubdiv INTERFACE ${TETRAKIS_OPENSUBDIV_LIBRARY})
  endif()
endif()
