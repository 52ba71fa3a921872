# Installs the build tree BUILD_DIR below WORK_DIR, then configures (with the build tree on PATH, too), builds and runs
# the consumer against it.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DGENERATOR=... -DCOMPILER=... [-DLAUNCHER=...] -P run.cmake
file(REMOVE_RECURSE ${WORK_DIR})
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
set(configure ${CMAKE_COMMAND} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
# find_package() looks beside the folders of PATH: the program's in the build tree must not be taken for a package.
run(${CMAKE_COMMAND} -E env "PATH=${BUILD_DIR}:${WORK_DIR}/prefix/bin:$ENV{PATH}" ${configure} -S ${CMAKE_CURRENT_LIST_DIR}
    -B ${WORK_DIR}/by_path)
run(${configure} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer)

# As a part of another project tetrakis leaks no flags, and installs nothing. Configuring shows it.
run(${configure} -S ${CMAKE_CURRENT_LIST_DIR}/subproject -B ${WORK_DIR}/subproject
    -DTETRAKIS_DIR=${CMAKE_CURRENT_LIST_DIR}/../.. -DCMAKE_EXPORT_COMPILE_COMMANDS=ON)
file(READ ${WORK_DIR}/subproject/compile_commands.json commands)
string(REGEX MATCH "[^\n]*consumer/main.cpp.o[^\n]*" command "${commands}")
if(NOT command OR command MATCHES " -(W|f|m)")
  message(FATAL_ERROR "flags that only tetrakis needs reach its users: ${command}")
endif()
file(READ ${WORK_DIR}/subproject/tetrakis/cmake_install.cmake rules)
if(rules MATCHES "file\\(INSTALL")
  message(FATAL_ERROR "a subproject has install rules")
endif()
